#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/identity.h"
#include "stiefel/scene.h"

namespace stiefel::server {

/// How a resolved description differs from the one that a caller gave, as paths of fields such as
/// "epsilon", "method" and "body.attitude".
struct Difference {
  std::vector<std::string> filled_in;  ///< resolved fields that were not given so
  std::vector<std::string> cleared;    ///< given fields that the resolved description lacks

  /// Whether `path` is a filled-in field or lies within one: "method.order" in "method".
  bool fills_in(std::string_view path) const;
};

/// Compares bits; the digests of the given description suffice. The parts of `body` are compared
/// one by one, every other field as a whole.
Difference difference(const FieldDigests& given, const FieldDigests& resolved);
Difference difference(const SceneDescription& given, const SceneDescription& resolved);

/// The tolerance and horizon for which a scene's method was chosen, and the reason for the choice
/// (Choice in tradeoff.h).
struct ChosenMethod {
  double tolerance;
  double horizon;
  std::string reason;
  double error;
  bool verified;
};

/// How a scene was resolved from what its caller gave.
struct Resolution {
  Difference difference;
  std::optional<ChosenMethod> choice;  ///< set where the method was chosen for a tolerance
};

}  // namespace stiefel::server
