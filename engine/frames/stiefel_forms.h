#pragma once

#include "engine/catalogue/system_entry.h"
#include "engine/scene/scene_draft.h"
#include "engine/stepping/stacked_observables.h"

namespace stiefel {

/// Returns the common data of the systems on V(n, N): blocks Q and `other`, energy, m,
/// orthogonality.
SystemInfo stiefel_info(BlockInfo other);

/// Checks Λ > 0 (at n = N too), a frame Q, n × N, n ≤ N, and the names of the blocks. Returns false
/// when there is a violation.
bool check_stiefel_frame(SceneDraft& draft, const char* frame = "Q");

/// Sets an n × N block after checking that its velocity is tangent: QQ̇ᵀ + Q̇Qᵀ = 0 within the
/// draft's largest_repair. A projection along the constraint forces then makes it tangent to
/// rounding.
void set_tangent(SceneDraft& draft, const char* name, bool is_velocity);

/// Sets an n × N block of costates, any of which belong to a velocity of about PΛ⁻¹.
void set_costate(SceneDraft& draft, const std::string& name, const RowMatrix& P);

using SizeOf = std::function<double(const Eigen::MatrixXd& x)>;

/// Returns a function that gives the size of the terms whose difference is S, for a state of two
/// blocks of n rows: κ(Λ)‖P‖_F where the second block is a costate P, and 0 where it is S or Q̇.
SizeOf terms_of_S(const Scene& scene, Eigen::Index n, bool costate);

/// Adds m and the energy of (Q, S), QQᵀ − I and ‖Q̇‖, for states from which Q and S follow. The
/// scales are E and ‖S‖_F, and at rest (at_rest.h) those of an S of the size of its terms.
void report_geodesic(StackedObservables& observables, const Scene& scene, Eigen::Index n,
                     std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)> S, SizeOf terms);

/// Returns the rough number of nanoseconds for a step.
double stiefel_cost(Eigen::Index n, Eigen::Index N);

}  // namespace stiefel
