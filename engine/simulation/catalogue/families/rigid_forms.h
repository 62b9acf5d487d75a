#pragma once

#include "engine/simulation/catalogue/families/rigid_body_invariants.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/stepping/stacked_observables.h"

namespace stiefel {

/// The rigid body in one of its other forms: how its Q and M follow from a state of it.
struct RigidForm {
  using MatrixOf = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)>;
  MatrixOf Q, M;
  Side side = Side::left;
  MatrixOf A = {};      ///< PQᵀ, on the right PᵀQ, if the form moves a P
  bool scaled = false;  ///< M stands multiplied by epsilon
  /// ‖·‖_F of the matrices that M is a difference of; none if the state holds M.
  std::function<double(const Eigen::MatrixXd& x)> terms = {};
};

/// The data that all forms share: blocks Q and `other`, fields, invariants.
SystemInfo rigid_form_info(BlockInfo other, bool has_P, Side side = Side::left);

/// The block P of the symmetric representations.
BlockInfo costate_block(Side side = Side::left);

/// ‖P‖_F/|ε| of a state Q over P: what their M is a difference of, ‖Q‖_op being 1.
std::function<double(const Eigen::MatrixXd& x)> costate_terms(int N, double epsilon);

/// Adds to the blocks what is computed from them: M, Omega, with a P epsilon, and the invariants.
void report_rigid_form(StackedObservables& observables, const Scene& scene, RigidForm form);

/// Q over P or whatever `other` is, 2N × N, as the scene starts.
Eigen::MatrixXd stacked(const Scene& scene, const char* first, const char* second);

}  // namespace stiefel
