#pragma once

#include "engine/simulation/stacked_readout.h"
#include "engine/simulation/system_entry.h"

namespace stiefel {

/// The rigid body in one of its other forms: how its Q and M follow from a state of it.
struct RigidForm {
  using MatrixOf = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)>;
  MatrixOf Q, M;
  bool right = false;   ///< Q_r and M_r
  MatrixOf A = {};      ///< PQᵀ (on the right (Q_rᵀP_r)ᵀ), if the form moves a P
  bool scaled = false;  ///< M stands multiplied by epsilon
};

/// The data that all forms share: blocks Q and `other`, fields, invariants.
SystemInfo rigid_form_info(BlockInfo other, bool has_P);

/// Adds to the blocks what is computed from them: M, Omega, with a P epsilon, and the invariants.
void report_rigid_form(StackedReadout& readout, const Scene& scene, RigidForm form);

/// Q over P or whatever `other` is, 2N × N, as the scene starts.
Eigen::MatrixXd stacked(const Scene& scene, const char* first, const char* second);

}  // namespace stiefel
