#pragma once

#include <array>
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

/// Returns |value − initial| / scale, or |value − initial| where the scale is 0, as it is at rest.
inline double drift_of(long double initial, long double value, long double scale) {
  const long double change = std::abs(value - initial);
  return static_cast<double>(scale > 0 || scale < 0 ? change / scale : change);
}

/// One scalar invariant with its drift: "energy", "spatial_momentum[0,1]", "manakov[3,1]" (the
/// coefficient of μ¹ in tr(M + μΛ²)³), "casimirs[0]".
struct InvariantDrift {
  std::string name;
  long double initial;
  long double value;
  long double scale;
  Conservation conservation;
  std::optional<std::int64_t> member = {};  ///< in an ensemble: the member with the largest drift
  double drift() const { return drift_of(initial, value, scale); }
};

/// The exact motion of a free rigid body in three dimensions from the state at step 0, from
/// Jacobi's closed form, in units of the scene. For a body with two equal moments the long axis is
/// that of the least moment, any in the plane if this is twofold.
struct BodyMotion {
  enum class Kind {
    at_rest,
    steady,      ///< a steady rotation about an axis
    short_axis,  ///< the momentum circles about the axis of the largest moment in the body
    long_axis,   ///< about that of the least moment
    separatrix,
  };

  Kind kind = Kind::at_rest;
  /// 1 − k² of the elliptic functions: 0 on the separatrix, where rounding grows by its inverse.
  double separatrix = 0;
  /// The period of the angular velocity in body axes; nullopt where there is none. The nutation has
  /// half of it.
  std::optional<double> period = {};
  /// 2π over the mean rate at which the axis of the least moment turns about the momentum, in a
  /// steady rotation 2π/|ω|; nullopt at rest.
  std::optional<double> precession_period = {};
  /// The least and the largest angle in radians between the momentum and the axis that it circles.
  std::array<double, 2> nutation = {0, 0};
  Eigen::Vector3d momentum;  ///< in space axes; of a scene without a frame, in body axes at step 0
  double energy = 0;
  Eigen::Vector3d moments;  ///< the principal moments, ascending
  Eigen::Matrix3d axes;     ///< columns: their axes in the caller's body axes, right-handed
};

/// Returns nullopt for an ensemble, a discrete system, and a scene that is no free rigid body with
/// n = N = 3.
std::optional<BodyMotion> body_motion(const Scene& scene);

struct Diagnosis {
  std::vector<InvariantDrift> invariants;
  std::optional<double> orthogonality;  ///< max |QQᵀ − I|
  double h_omega = 0;                   ///< |h| ‖Ω‖, or |h| ‖Q̇‖ where n < N
  std::optional<double> largest_step;
  std::optional<BodyMotion> motion;
};

/// Whether the name, without an index in brackets, is a family of invariants of the scene's system:
/// "energy", "spatial_momentum", "spatial_momentum[0,1]", ...
bool is_invariant(const Scene& scene, std::string_view name_or_family);

/// Compares the invariants at the state of `now` with those at step 0. `only` selects families or
/// names; when it is empty, all families are computed, the Manakov coefficients only up to N = 16
/// (they cost N⁵ operations). When `stop` requests a stop, the result lacks what was not yet
/// computed.
Diagnosis diagnose(const Scene& scene, const Simulation& now,
                   std::span<const std::string> only = {}, const std::stop_token& stop = {});

/// A tangent vector: its blocks by the names of the state's blocks.
using TangentVector = std::map<std::string, Block>;

/// Returns ω(u, v) at the state of `now`. Refuses a form that the system does not have, blocks that
/// are not the form's, and vectors that are not tangent to 1e-8. The violations name the fields
/// "form", "first" and "second".
std::expected<double, Violations> evaluate_form(const Scene& scene, const Simulation& now,
                                                const std::string& form, const TangentVector& u,
                                                const TangentVector& v);

/// Returns max |ω(Tφu, Tφv) − ω(u, v)| / ‖u‖‖v‖ over `pairs` pairs of random tangent vectors, drawn
/// with `seed`, at the state of `now`. φ is one step of the scene's method and ω the system's first
/// form. The defect of a symplectic φ is about 1e-12. Returns nullopt where φ is not defined around
/// the state, and on a stop request. Refuses a system that has no form.
std::expected<std::optional<double>, Violations> symplectic_defect(
    const Scene& scene, const Simulation& now, int pairs, unsigned seed,
    const std::stop_token& stop = {});

/// A function on gl(N) × gl(N) ∋ (Q, P): a product of linear functions tr AᵀQ + tr BᵀP, given as A
/// and B.
struct PairFactors {
  std::vector<std::pair<RowMatrix, RowMatrix>> factors;
};

/// Returns the Dirac bracket {F, K} on S, [RB] (3.15), at the state (Q, P) of `now`. Refuses
/// systems without P and matrices that are not N × N. The violations name the fields "first" and
/// "second".
std::expected<double, Violations> dirac_bracket(const Scene& scene, const Simulation& now,
                                                const PairFactors& F, const PairFactors& K);

}  // namespace stiefel
