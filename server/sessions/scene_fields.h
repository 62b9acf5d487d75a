#pragma once

#include <tuple>
#include <type_traits>

#include "stiefel/scene.h"

namespace stiefel::server {

/// A field of a description: its name, also in proto and in files, and the member variable that
/// holds it.
template <class Owner, class Value>
struct SceneField {
  std::string_view name;
  Value Owner::*member;
};

/// All fields of a description in the order of their declaration: the one list from which identity
/// and wire form are derived.
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
inline constexpr auto fields_of<BodyDescription> =
    std::tuple(SceneField{"inertia_tensor", &BodyDescription::inertia_tensor},
               SceneField{"moments", &BodyDescription::moments},
               SceneField{"attitude", &BodyDescription::attitude},
               SceneField{"angular_velocity", &BodyDescription::angular_velocity});

template <>
inline constexpr auto fields_of<SceneDescription> = std::tuple(
    SceneField{"system", &SceneDescription::system},
    SceneField{"method", &SceneDescription::method},
    SceneField{"inertia", &SceneDescription::inertia},
    SceneField{"inertia_u", &SceneDescription::inertia_u},
    SceneField{"inertia_v", &SceneDescription::inertia_v},
    SceneField{"initial", &SceneDescription::initial}, SceneField{"body", &SceneDescription::body},
    SceneField{"epsilon", &SceneDescription::epsilon},
    SceneField{"parameter", &SceneDescription::parameter},
    SceneField{"step", &SceneDescription::step},
    SceneField{"tolerance", &SceneDescription::tolerance},
    SceneField{"horizon", &SceneDescription::horizon},
    SceneField{"members", &SceneDescription::members});

template <class T>
concept Description = !std::is_null_pointer_v<std::remove_cv_t<decltype(fields_of<T>)>>;

/// Calls visit(field) with each SceneField of the description's type, in order.
template <Description T, class Visit>
constexpr void for_each_field(Visit&& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, fields_of<T>);
}

/// Whether the list has every member of the struct, of which none has padding.
template <Description T>
inline constexpr bool lists_every_member =
    std::apply(
        [](const auto&... field) { return (... + sizeof(std::declval<T&>().*field.member)); },
        fields_of<T>) == sizeof(T);

static_assert(lists_every_member<MethodDescription>);
static_assert(lists_every_member<BodyDescription>);
static_assert(lists_every_member<SceneDescription>);

}  // namespace stiefel::server
