// The kinds of structure that the registry's methods trace, for code that does something else with each of them.
#pragma once

#include <optional>
#include <type_traits>

#include "libaccel/registry/any_structure.h"
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

// What visit() returns for the structure as the type that it is; nothing if it is of no kind in the list.
template <class Visitor>
auto visit_structure(const AnyStructure& any, Visitor&& visit) {
  std::optional<std::invoke_result_t<Visitor&, const Structures::At<0>&>> result;
  Structures::for_each([&](auto tag) {
    if (const auto* structure = any.get_if<typename decltype(tag)::type>()) result.emplace(visit(*structure));
  });
  return result;
}

}  // namespace accel
