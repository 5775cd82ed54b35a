// A list of types to iterate over, where an array of values would not do.
#pragma once

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

namespace accel {

template <class T>
struct TypeTag {
  using type = T;
};

template <class... Ts>
struct TypeList {
  static constexpr std::size_t size = sizeof...(Ts);

  template <std::size_t kIndex>
  using At = std::tuple_element_t<kIndex, std::tuple<Ts...>>;

  // The place of T in the list; its size where T is not in it.
  template <class T>
  static constexpr std::size_t index_of() {
    std::size_t index = 0;
    bool found = false;
    ((found = found || std::is_same_v<T, Ts>, index += found ? 0 : 1), ...);
    return index;
  }

  // Calls visit(TypeTag<T>{}) for each type, in order.
  template <class Visitor>
  static constexpr void for_each(Visitor&& visit) {
    (visit(TypeTag<Ts>{}), ...);
  }

  // The list with T behind it, unless T is in it.
  template <class T>
  using AppendUnique = std::conditional_t<(std::is_same_v<T, Ts> || ...), TypeList, TypeList<Ts..., T>>;

  // Template<Ts...>
  template <template <class...> class Template>
  using Apply = Template<Ts...>;
};

}  // namespace accel
