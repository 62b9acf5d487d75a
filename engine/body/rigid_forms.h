#pragma once

#include "engine/motion/body_view.h"
#include "engine/motion/invariant_list.h"
#include "engine/motion/observables.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

/// Returns the invariants of (Q, M) in the rigid body's catalogue entry, without orthogonality.
std::vector<InvariantInfo> rigid_body_invariant_infos(Side side = Side::left);

/// Adds the values of the invariants, computed in extended precision: QMQᵀ on the left, QᵀMQ on the
/// right. Q is empty in a momentum-only scene. The Manakov coefficients cost N⁵ operations, so they
/// are included only up to N = 16 unless they are asked for. The scale of the energy is E, the
/// other scales are powers of ‖M‖. For a body at rest, whose M is only rounding (is_rounding), the
/// scales are those of an M of the size of its `terms`, the matrices whose difference is M; 0 where
/// the state holds M itself.
void rigid_body_invariants(Side side, const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                           const Eigen::MatrixXd& M, InvariantList& out, double terms = 0);

/// The invariant that discrete rigid bodies keep in addition to those of the continuous one.
inline constexpr InvariantInfo discrete_hamiltonian_info = {
    family::discrete_hamiltonian,
    "tr exp(asinh(h M / 2)) - tr(Lambda U), U Lambda - Lambda U^T = h M", "[RB] (6.17)"};

/// Adds the discrete Hamiltonian where h‖M‖_op ≤ 2 and J_D⁻¹(hM) is on the principal branch;
/// elsewhere adds nothing. Call it after all other families.
void add_discrete_hamiltonian(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                              InvariantList& out);

/// Returns ‖Ω‖, the operator norm.
double angular_velocity_norm(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M);

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

/// Adds the fields that are computed from the blocks: M, Omega, epsilon for a form with P; the
/// invariants, also those of the discrete body alone; and the angular velocity.
void report_rigid_form(Observables& observables, const Scene& scene, const RigidForm& form);

/// Returns the observables of a scene with a rigid body, or with a view of one: in three dimensions
/// the points are (q; m) or m, else Q over M or M.
SharedObservables rigid_body_observables(const Scene& scene);

}  // namespace stiefel
