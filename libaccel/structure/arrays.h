// A structure lists its arrays once; what goes through all of them (sizes, files, copies to devices) is written here and in
// terms of that list, for structures of any kind.
//
// A structure of arrays is a type with
//
//   static constexpr const char* kName;                // no other kind has it
//   using View = ...;  View view() const;              // pointers to the arrays, and what else traversal needs
//   using Words = ...;                                 // optional: its base class, of all that is no array, without padding
//   template <class Self, class Visit>                 // visit(name, array) for each Buffer, in a fixed order; Self is const
//   static void for_each_array(Self&, Visit&&);        // or not
//   Status validate(const Structure&, std::uint64_t);  // proves for any bytes what traversal relies on
#pragma once

#include <cstddef>
#include <string_view>

#include "libaccel/core/buffer.h"

namespace accel {

namespace detail {
struct AnyVisitor {
  template <class Array>
  void operator()(std::string_view, Array&) const {}
};
}  // namespace detail

template <class Structure>
concept StructureOfArrays = requires(const Structure& s) {
  Structure::kName;
  s.view();
  Structure::for_each_array(s, detail::AnyVisitor{});
};

template <StructureOfArrays Structure>
std::size_t bytes_of_arrays(const Structure& structure) {
  std::size_t bytes = 0;
  Structure::for_each_array(structure, [&](std::string_view, const auto& array) { bytes += array.size_bytes(); });
  return bytes;
}

}  // namespace accel
