#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/identity.h"
#include "stiefel/scene.h"

namespace stiefel::server {

/// How a resolved description differs from the one that a caller gave: "epsilon", "method",
/// "body.attitude".
struct Difference {
  std::vector<std::string> filled_in;  ///< fields that are there and not as given
  std::vector<std::string> cleared;    ///< fields that were given and are not there

  /// Whether a field is filled in, or is in one that is: "method.order" in "method".
  bool fills_in(std::string_view path) const;
};

/// Compares bits, of which the given description's digests are enough. The parts of `body` are
/// fields of their own, all others are taken whole.
Difference difference(const FieldDigests& given, const FieldDigests& resolved);
Difference difference(const SceneDescription& given, const SceneDescription& resolved);

/// What a scene's method was chosen for, and why this one.
struct ChosenMethod {
  double tolerance;
  double horizon;
  std::string reason;
};

/// How a scene came from what its caller gave.
struct Resolution {
  Difference difference;
  std::optional<ChosenMethod> choice;  ///< where the method was chosen for a tolerance
};

}  // namespace stiefel::server
