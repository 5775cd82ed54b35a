// One of the structures that the registry's builders make.
#pragma once

#include <variant>

#include "libaccel/registry/methods.h"

namespace accel {

namespace detail {
template <class List, class... Ms>
struct StructuresOf {
  using type = List;
};
template <class List, class M, class... Ms>
struct StructuresOf<List, M, Ms...> : StructuresOf<typename List::template AppendUnique<typename M::Structure>, Ms...> {};

template <class... Ms>
using UniqueStructures = typename StructuresOf<TypeList<>, Ms...>::type;
}  // namespace detail

// The structure types of all methods, each once.
using Structures = Methods::Apply<detail::UniqueStructures>;
using AnyStructure = Structures::Apply<std::variant>;

inline std::size_t size_bytes(const AnyStructure& structure) {
  return std::visit([](const auto& s) { return s.size_bytes(); }, structure);
}

}  // namespace accel
