#pragma once

#include <array>

#include "engine/frame/stiefel_momenta.h"
#include "engine/motion/observables.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

extern const SeriesEquations frame_equations;

/// Returns the common data of the systems on V(n, N): blocks Q and `other`, energy, m,
/// orthogonality.
SystemInfo stiefel_info(BlockInfo other);

/// Checks Λ > 0 (at n = N too), a frame Q, n × N, n ≤ N, and the names of the blocks. Returns false
/// when there is a violation.
bool check_stiefel_frame(SceneDraft& draft, const char* frame = "Q");

/// Sets an n × N block, S or with `is_velocity` Q̇, after checking that its velocity is tangent to
/// the frames: QQ̇ᵀ + Q̇Qᵀ = 0 within the draft's largest_repair. A projection along the constraint
/// forces then makes it tangent to rounding.
void set_tangent(SceneDraft& draft, const char* frame, const char* name, bool is_velocity);

/// Sets an n × N block of costates, any of which belong to a velocity of about PΛ⁻¹.
void set_costate(SceneDraft& draft, const std::string& name, const RowMatrix& P);

/// Returns the phase of Q and any costate P, for example S: S by 𝔐⁻¹, at n = N only M.
Phase phase_of_costate(const Scene& scene, const Eigen::MatrixXd& Q, const Eigen::MatrixXd& P);
/// Reads (Q, P).
WithinDomain<Phase> read_costate(const Scene& scene, Margins&);
/// Returns S of a phase, at n = N from M.
Eigen::MatrixXd S_of(const Phase& x);
/// M is an N × N block up to this N.
inline constexpr Eigen::Index largest_written_M = 4096;
/// The invariants of the Lax matrix are reported unasked up to this N.
inline constexpr Eigen::Index largest_lax_unasked = 8;

/// Returns the start of a motion from the blocks of a frame and a costate, by 𝔐⁻¹. Makes the rows
/// of the frame, which are orthonormal to rounding in double precision, orthonormal in Scalar: each
/// of two iterations of Newton and Schulz squares the defect, which is 1e-16 at first.
template <class Scalar>
SeriesStart<Scalar> start_of_costate(const SceneNumbers<Scalar>& g, const char* frame,
                                     const char* costate);
// Compiled once, in stiefel_forms.cc.
extern template SeriesStart<long double> start_of_costate(const SceneNumbers<long double>&,
                                                          const char*, const char*);
extern template SeriesStart<Quad> start_of_costate(const SceneNumbers<Quad>&, const char*,
                                                   const char*);

/// Recommendations for costates on V(n, N). At n = 1 the motion is integrable, and its condition
/// stays small while its speed varies up to the root of λ_max/λ_min.
inline bool is_one_point(const Scene& scene) { return scene.Q().rows() == 1; }
inline constexpr std::array for_costates = {
    restricted("n = 1", is_one_point, with_error_control(5e-12, 0.15)),
    with_error_control(3e-11, 0.15)};

/// S of a state, Q over S or over a costate P, n rows each.
struct SOfState {
  Eigen::VectorXd lambda;
  Eigen::Index n;
  bool costate;

  Eigen::MatrixXd operator()(const Eigen::MatrixXd& x) const {
    if (!costate) return x.bottomRows(n);
    return Legendre_inverse<double>(lambda, x.topRows(n), x.bottomRows(n));
  }
  Eigen::MatrixXd Qdot(const Eigen::MatrixXd& x) const { return Qdot_of_S(lambda, (*this)(x)); }
  /// Returns the size of the terms whose difference is S: κ(Λ)‖P‖_F, and 0 where S is in the state.
  double terms(const Eigen::MatrixXd& x) const {
    return costate ? lambda.maxCoeff() / lambda.minCoeff() * x.bottomRows(n).stableNorm() : 0;
  }
};

/// Adds m and the energy of (Q, S), QQᵀ − I and ‖Q̇‖. The scales are E and ‖S‖_F, and at rest
/// (is_rounding) those of an S of the size of its terms.
void report_geodesic(Observables& observables, const SOfState& S);

}  // namespace stiefel
