#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the SHA-256 (32 bytes) of a resolved description: of the names, the shapes and the bits
/// of all its values. Equal exactly for equal scenes.
std::string identity_of(const SceneDescription& resolved);

/// The paths of the fields that a description sets, in order, each with the SHA-256 of its value.
/// The parts of `body` ("body.moments") follow `body` itself, which has no digest.
using FieldDigests = std::vector<std::pair<std::string, std::string>>;
FieldDigests field_digests(const SceneDescription& description);

/// Returns the FNV-1a hash, 64 bits. A change of one byte always changes it.
std::uint64_t hash(std::string_view bytes);

/// A digest of all that may change the bits of a state (build_fingerprint), 16 hexadecimal digits.
/// Two servers with the same id compute the same states.
const std::string& numerics_id();

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
};

/// How a scene was resolved from what its caller gave.
struct Resolution {
  Difference difference;
  std::optional<ChosenMethod> choice;  ///< set where the method was chosen for a tolerance
};

}  // namespace stiefel::server
