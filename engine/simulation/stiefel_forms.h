#pragma once

#include "engine/simulation/scene_draft.h"
#include "engine/simulation/stacked_readout.h"
#include "engine/simulation/system_entry.h"

namespace stiefel {

/// What the systems on V(n, N) have in common: blocks Q and `other`, energy, m, orthogonality.
SystemInfo stiefel_info(BlockInfo other);

/// Λ > 0 (at n = N too) and a frame Q, n × N, n ≤ N; the names of the blocks. False when something
/// is wrong.
bool check_stiefel_frame(SceneDraft& draft, const char* frame = "Q");

/// A block n × N whose rows `velocity` makes tangent: QQ̇ᵀ + Q̇Qᵀ = 0 within the draft's
/// largest_repair, and then exactly, by projection along the constraint's forces.
void set_tangent(SceneDraft& draft, const char* name, bool is_velocity);

/// m and the energy of (Q, S), QQᵀ − I and ‖Q̇‖, for states from which Q and S follow.
void report_geodesic(StackedReadout& readout, const Scene& scene, Eigen::Index n,
                     std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)> S);

/// A step in nanoseconds, roughly.
double stiefel_cost(Eigen::Index n, Eigen::Index N);

}  // namespace stiefel
