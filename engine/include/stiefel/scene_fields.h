#pragma once

#include <tuple>
#include <type_traits>

#include "stiefel/scene.h"

namespace stiefel {

/// How the members of an ensemble share a field.
namespace share {
/// One value is common to all members.
struct Common {};
/// Each member has its own rows of every block.
struct Rows {};
/// `each` numbers are common to all members; `each` times the number of members are the members' in
/// turn.
struct Numbers {
  std::size_t each;
};
/// A member has one number for each row, or for each column, of its blocks.
struct NumberPerRow {};
struct NumberPerColumn {};
/// A field of the ensemble that its members do not have.
struct Ensemble {};
}  // namespace share

/// A field of a description: its name, also in proto and in files, and the member variable that
/// holds it.
template <class Owner, class Value, class Share = share::Common>
struct SceneField {
  std::string_view name;
  Value Owner::*member;
  Share shared = {};
};

/// All fields of a description in the order of their declaration: the one list from which identity,
/// wire form and members of an ensemble are derived.
template <class Description>
inline constexpr auto fields_of = nullptr;

template <>
inline constexpr auto fields_of<MethodDescription> = std::tuple(
    SceneField{"name", &MethodDescription::name}, SceneField{"order", &MethodDescription::order},
    SceneField{"substeps", &MethodDescription::substeps},
    SceneField{"arithmetic", &MethodDescription::arithmetic},
    SceneField{"tolerance", &MethodDescription::tolerance},
    SceneField{"scalar", &MethodDescription::scalar});

template <>
inline constexpr auto fields_of<BodyDescription> = std::tuple(
    SceneField{"inertia_tensor", &BodyDescription::inertia_tensor, share::Numbers{6}},
    SceneField{"moments", &BodyDescription::moments, share::Numbers{3}},
    SceneField{"attitude", &BodyDescription::attitude, share::Numbers{4}},
    SceneField{"angular_velocity", &BodyDescription::angular_velocity, share::Numbers{3}});

template <>
inline constexpr auto fields_of<SceneDescription> = std::tuple(
    SceneField{"system", &SceneDescription::system},
    SceneField{"method", &SceneDescription::method},
    SceneField{"inertia", &SceneDescription::inertia, share::NumberPerColumn{}},
    SceneField{"inertia_u", &SceneDescription::inertia_u, share::NumberPerRow{}},
    SceneField{"inertia_v", &SceneDescription::inertia_v, share::NumberPerColumn{}},
    SceneField{"initial", &SceneDescription::initial, share::Rows{}},
    SceneField{"body", &SceneDescription::body}, SceneField{"epsilon", &SceneDescription::epsilon},
    SceneField{"parameter", &SceneDescription::parameter},
    SceneField{"step", &SceneDescription::step},
    SceneField{"tolerance", &SceneDescription::tolerance},
    SceneField{"horizon", &SceneDescription::horizon},
    SceneField{"members", &SceneDescription::members, share::Ensemble{}});

template <class T>
concept Description = !std::is_null_pointer_v<std::remove_cv_t<decltype(fields_of<T>)>>;

/// Calls visit(field) with each SceneField of the description's type, in order.
template <Description T, class Visit>
constexpr void for_each_field(Visit&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, fields_of<T>);
}

namespace detail {

// A structured binding needs a name for every member, so a new member that is not listed here does
// not compile.
inline auto members_of(const MethodDescription& d) {
  const auto& [a, b, c, e, f, g] = d;
  return std::tie(a, b, c, e, f, g);
}
inline auto members_of(const BodyDescription& d) {
  const auto& [a, b, c, e] = d;
  return std::tie(a, b, c, e);
}
inline auto members_of(const SceneDescription& d) {
  const auto& [a, b, c, e, f, g, h, i, j, k, l, m, n] = d;
  return std::tie(a, b, c, e, f, g, h, i, j, k, l, m, n);
}

/// Checks that the list has as many fields as the struct, of the same types in the same order, and
/// no field twice.
template <class T>
consteval bool lists_every_member() {
  return std::apply(
      [](const auto&... field) {
        using Listed = std::tuple<
            const std::remove_reference_t<decltype(std::declval<T&>().*field.member)>&...>;
        const auto same = [](const auto& a, const auto& b) {
          if constexpr (std::is_same_v<decltype(a.member), decltype(b.member)>)
            return a.member == b.member;
          return false;
        };
        const auto times = [&](const auto& one) { return (0 + ... + int{same(one, field)}); };
        return std::is_same_v<Listed, decltype(members_of(std::declval<const T&>()))> &&
               ((times(field) == 1) && ...);
      },
      fields_of<T>);
}

static_assert(lists_every_member<MethodDescription>());
static_assert(lists_every_member<BodyDescription>());
static_assert(lists_every_member<SceneDescription>());

}  // namespace detail
}  // namespace stiefel
