#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "server/sessions/session.h"

/// Prices in instructions.
namespace stiefel::server {

/// Returns the instructions that finding the substeps of a system's recommended method takes for a
/// scene whose blocks have at most `columns` columns; 0 where that is negligible. `members` is 0 or
/// 1 for a single scene.
double recommendation_work(std::string_view system, std::uint32_t members, std::uint64_t columns);

/// Returns the predicted instructions of making a session: of resolving its scene and of one
/// simulation a member. `N`: `whole_dimension`. `members`: 1 for a single scene.
double creation_work(double N, double members);
/// Returns the predicted instructions of a conversion to the system for which it takes most.
double conversion_work(double N, double members);
/// Returns the predicted instructions of a fork, with a conversion or without.
double fork_work(const Session& from, bool converts);

/// What the price of a Diagnose depends on, beside its session.
struct DiagnosisSize {
  bool manakov = false;          ///< whether the invariants include the coefficients of Manakov
  bool singular_values = false;  ///< whether they include those of complex blocks
  std::size_t forms = 0;
  std::vector<std::size_t> factors;  ///< of each Dirac bracket, of both of its functions
  std::uint32_t pairs = 0;           ///< of tangent vectors, of the symplectic test
  double estimate_work = 0;          ///< the most that an estimate of the error may take
};
/// Returns the predicted instructions of a Diagnose without its steps, from its matrix products.
double diagnosis_work(const Session& session, const DiagnosisSize& size);

}  // namespace stiefel::server
