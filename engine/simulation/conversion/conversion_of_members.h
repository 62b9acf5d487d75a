#pragma once

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"

namespace stiefel {

/// `convert` of an ensemble to another form: each member is converted, and the results stand one
/// after another in one ensemble, blocks by their rows. Margins are the smallest of any member.
/// A refusal names the member.
std::expected<Conversion, ConversionRefusal> convert_members(const Scene& ensemble,
                                                             const ConversionTarget& target);

/// The scene's method where the system takes it; else none, so that it gets the recommended one.
std::optional<MethodDescription> method_on(const SystemInfo& system, const Scene& scene);

/// The fields of a scene that a conversion makes come of the target, but for what was asked for.
Place place_of_result(const ConversionTarget& target);

}  // namespace stiefel
