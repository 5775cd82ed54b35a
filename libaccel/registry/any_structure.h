// A structure of any kind, with its type erased: what builders make, files hold and methods trace.
//
// Copies share the structure, and nothing changes it once it is in here; moving is copying, so that no handle is ever empty.
// This header knows no kind and no traverser, so that adding one recompiles nobody who passes structures on; code that must
// know all kinds includes registry/structures.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>

namespace accel {

class AnyStructure {
 public:
  // Takes any structure of structure/, implicitly: it has a kName that no other kind has, and size_bytes().
  template <class Structure>
  requires requires(const Structure& s) { Structure::kName, s.size_bytes(); }
  AnyStructure(Structure structure)
      : kind_(Structure::kName),
        size_bytes_(structure.size_bytes()),
        depth_(depth_of(structure)),
        object_(std::make_shared<const Structure>(std::move(structure))) {}
  AnyStructure(const AnyStructure&) = default;
  AnyStructure& operator=(const AnyStructure&) = default;

  std::string_view kind() const { return kind_; }  // Structure::kName
  std::size_t size_bytes() const { return size_bytes_; }
  std::uint32_t depth() const { return depth_; }  // 0 for what is no tree

  // The structure itself, or null if it is of another kind.
  template <class Structure>
  const Structure* get_if() const {
    return kind_ == Structure::kName ? static_cast<const Structure*>(object_.get()) : nullptr;
  }

 private:
  template <class Structure>
  static std::uint32_t depth_of(const Structure& structure) {
    if constexpr (requires { structure.depth; })
      return structure.depth;
    else
      return 0;
  }

  std::string_view kind_;
  std::size_t size_bytes_;
  std::uint32_t depth_;
  std::shared_ptr<const void> object_;
};

}  // namespace accel
