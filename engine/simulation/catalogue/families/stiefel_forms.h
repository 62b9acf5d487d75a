#pragma once

#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/scene/scene_draft.h"
#include "engine/simulation/stepping/stacked_observables.h"

namespace stiefel {

/// The common data of the systems on V(n, N): blocks Q and `other`, energy, m, orthogonality.
SystemInfo stiefel_info(BlockInfo other);

/// Λ > 0 (at n = N too) and a frame Q, n × N, n ≤ N; the names of the blocks. False when something
/// is wrong.
bool check_stiefel_frame(SceneDraft& draft, const char* frame = "Q");

/// A block n × N whose rows `velocity` makes tangent: QQ̇ᵀ + Q̇Qᵀ = 0 within the draft's
/// largest_repair, and then exactly, by projection along the constraint's forces.
void set_tangent(SceneDraft& draft, const char* name, bool is_velocity);

using SizeOf = std::function<double(const Eigen::MatrixXd& x)>;

/// The size of what S is a difference of, rounding included, for a state of two blocks of n rows:
/// λ_max √n/|h|, because a step makes S from frames that are rounded, and where the second block is
/// a costate P κ(Λ)‖P‖_F more.
SizeOf momentum_terms(const Scene& scene, Eigen::Index n, bool costate);

/// m and the energy of (Q, S), QQᵀ − I and ‖Q̇‖, for states from which Q and S follow. Scales are E
/// and ‖S‖_F, and at rest (at_rest.h) those of an S of the size of its terms.
void report_geodesic(StackedObservables& observables, const Scene& scene, Eigen::Index n,
                     std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)> S, SizeOf terms);

/// A step in nanoseconds, roughly.
double stiefel_cost(Eigen::Index n, Eigen::Index N);

}  // namespace stiefel
