#pragma once

#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"

namespace stiefel {

/// Converts an ensemble to another form: converts each member and joins the results in one
/// ensemble, the blocks by their rows. Each margin is the smallest of any member. A refusal names
/// the member.
std::expected<Conversion, ConversionRefusal> convert_members(const Scene& ensemble,
                                                             const ConversionTarget& target);

/// Returns the scene's method if the system takes it; else nullopt, so that the system gets its
/// recommended method.
std::optional<MethodDescription> method_on(const SystemInfo& system, const Scene& scene);

/// Returns the place of violations in the converted scene: the target, except for `epsilon` and
/// `parameter` if the request gives them.
Place place_of_result(const ConversionTarget& target);

}  // namespace stiefel
