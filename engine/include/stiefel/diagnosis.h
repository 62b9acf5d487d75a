#pragma once

#include <cmath>
#include <expected>
#include <map>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// |value − initial| / scale; |value − initial| where the scale is 0, which it is at rest.
inline double drift_of(long double initial, long double value, long double scale) {
  const long double change = std::abs(value - initial);
  return static_cast<double>(scale > 0 || scale < 0 ? change / scale : change);
}

/// One number that the exact motion keeps: "energy", "spatial_momentum[1,2]", "manakov[3,1]" (the
/// coefficient of μ¹ in tr(M + μΛ²)³), "casimirs[1]".
struct InvariantDrift {
  std::string name;
  long double initial;
  long double value;
  long double scale;
  Conservation conservation;
  std::optional<std::int64_t> member = {};  ///< in an ensemble: the member with the largest drift
  double drift() const { return drift_of(initial, value, scale); }
};

struct Diagnosis {
  std::vector<InvariantDrift> invariants;
  std::optional<double> orthogonality;  ///< max |QQᵀ − I|
  double h_omega = 0;                   ///< |h| ‖Ω‖, or |h| ‖Q̇‖ where n < N
  std::optional<double> largest_step;
};

/// The families of invariants that can be asked for: "energy", "spatial_momentum", ...
bool is_invariant(const Scene& scene, std::string_view name_or_family);

/// Invariants of `now` beside those at step 0. `only`: families or names; when empty every family,
/// the Manakov coefficients up to N = 16 (they cost N⁵ operations). Asked to stop it leaves out
/// what it has not computed.
Diagnosis diagnose(const Scene& scene, const Simulation& now,
                   std::span<const std::string> only = {}, const std::stop_token& stop = {});

/// A tangent vector by the names of the state's blocks.
using TangentVector = std::map<std::string, Block>;

/// ω(u, v) at the state of `now`. Refused: a form that the system does not have, blocks that are
/// not the form's, and vectors that are not tangent to 1e-8. The violations are of the fields
/// "form", "first" and "second" of `place`.
std::expected<double, Violations> evaluate_form(const Scene& scene, const Simulation& now,
                                                const std::string& form, const TangentVector& u,
                                                const TangentVector& v, const Place& place);

/// max |ω(Tφu, Tφv) − ω(u, v)| / ‖u‖‖v‖ over `pairs` seeded pairs of tangent vectors at the state
/// of `now`, φ one step of the scene's method and ω the system's first form. About 1e-12 for a
/// symplectic φ; nothing where φ is not defined around the state, or when it is asked to stop.
/// Refused for a system that has no form, as a violation of `place`.
std::expected<std::optional<double>, Violations> symplectic_defect(
    const Scene& scene, const Simulation& now, int pairs, unsigned seed, const Place& place,
    const std::stop_token& stop = {});

/// A product of functions tr AᵀQ + tr BᵀP, given as A and B.
struct PairFactors {
  std::vector<std::pair<RowMatrix, RowMatrix>> factors;
};

/// The Dirac bracket {F, K} on S, [RB] (3.15), at the state (Q, P) of `now`. Refused for systems
/// without a P and for matrices that are not N × N. The violations are of the fields "first" and
/// "second" of `place`.
std::expected<double, Violations> dirac_bracket(const Scene& scene, const Simulation& now,
                                                const PairFactors& F, const PairFactors& K,
                                                const Place& place);

}  // namespace stiefel
