#pragma once

#include "engine/body/rigid_body_invariants.h"
#include "engine/motion/body_view.h"
#include "engine/motion/stacked_observables.h"
#include "engine/motion/system_entry.h"

namespace stiefel {

/// A form of the rigid body: how Q and M of the body follow from a state of the form.
struct RigidForm {
  using MatrixOf = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)>;
  MatrixOf Q, M;  ///< Q is empty in a scene without a frame
  Side side = Side::left;
  MatrixOf A = {};      ///< PQᵀ, or PᵀQ on the right, if the form moves a P
  bool scaled = false;  ///< whether epsilon multiplies M
  /// Returns ‖·‖_F of the matrices whose difference is M; empty if the state holds M.
  std::function<double(const Eigen::MatrixXd& x)> terms = {};
};

/// Returns the data that all forms share: blocks Q and `other`, fields, invariants.
SystemInfo rigid_form_info(BlockInfo other, bool has_P, Side side = Side::left);

/// Adds the fields that are computed from the blocks: M, Omega, epsilon for a form with P.
void report_rigid_fields(StackedObservables& observables, const Scene& scene,
                         const RigidForm& form);
/// Adds the invariants, also those of the discrete body alone, and the angular velocity.
void report_rigid_invariants(StackedObservables& observables, const Scene& scene, RigidForm form);

/// Returns the observables of a scene with a rigid body, or with a view of one: in three dimensions
/// the points are (q; m) or m, else Q over M or M.
SharedObservables rigid_body_observables(const Scene& scene);

}  // namespace stiefel
