// How a key of the schema reaches its value: paths of members, and elements of lists.
#pragma once

#include "engine/scene/scene_schema.h"

namespace pliant::schema {

template <auto first, auto... rest> auto& follow(auto& object) {
  if constexpr (sizeof...(rest) == 0)
    return object.*first;
  else
    return follow<rest...>(object.*first);
}
template <class Class, class Member> Class class_of(Member Class::*);

/// The slot at a path of members: at<&Boundary::motion, &Motion::velocity>.
template <auto first, auto... rest> Slot at(void* object) {
  return &follow<first, rest...>(*static_cast<decltype(class_of(first))*>(object));
}
template <auto first, auto... rest> void* child(void* object) {
  return &follow<first, rest...>(*static_cast<decltype(class_of(first))*>(object));
}
template <auto first, auto... rest> std::vector<void*> only(void* object) {
  return {child<first, rest...>(object)};
}
template <auto member> void* append(void* object) {
  return &(static_cast<decltype(class_of(member))*>(object)->*member).emplace_back();
}
template <auto member> std::vector<void*> every(void* object) {
  std::vector<void*> found;
  for (auto& element : static_cast<decltype(class_of(member))*>(object)->*member) found.push_back(&element);
  return found;
}

/// `axis` and `degrees` of a turn.
inline std::vector<Key> turn_keys(Slot (*axis)(void*), Slot (*degrees)(void*)) {
  return {{.name = "axis",
           .meaning = "axis; any length but zero",
           .slot = axis,
           .example = "[0, 1, 0]",
           .required = true,
           .direction = true},
          {.name = "degrees",
           .meaning = "angle",
           .slot = degrees,
           .unit = "degrees",
           .example = "90",
           .required = true}};
}

constexpr Range positive{.low = 0, .above = true};
constexpr Range not_negative{.low = 0};
constexpr Range unit_interval{.low = 0, .high = 1};
constexpr Range horizon_range{
    .low = 1.2, .high = 4.1, .why = "a shorter one leaves too few bonds, a longer one costs too many"};

} // namespace pliant::schema
