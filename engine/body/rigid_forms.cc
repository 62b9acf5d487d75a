#include "engine/body/rigid_forms.h"

#include "engine/dense/inertia_operator.h"
#include "engine/dense/orthogonal.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

SystemInfo rigid_form_info(BlockInfo other, bool has_P, Side side) {
  const bool left = side == Side::left;
  SystemInfo info{};
  info.blocks = {{"Q", "N x N", true, "frame, orthogonal"}, other};
  if (other.name != "M")
    info.blocks.push_back(
        {"M", "N x N", false, "momentum, skew: may be given instead of the block before it"});
  info.fields = {{"Q", "N x N", "frame, orthogonal"},
                 {other.name, other.shape, other.description},
                 {"M", "N x N", left ? "body momentum, skew" : "momentum, skew"},
                 {"Omega", "N x N",
                  left ? "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)"
                       : "angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)"}};
  if (other.name == "M") info.fields.erase(info.fields.begin() + 1);
  info.invariants = rigid_body_invariant_infos(side);
  if (has_P) {
    info.fields.push_back(
        {"epsilon", "1 x 1",
         left ? "M = (Q^T P - P^T Q) / epsilon" : "M = (P Q^T - Q P^T) / epsilon"});
    info.invariants.push_back({family::PQt, left ? "P Q^T" : "P^T Q", "[RB] (8.2)"});
  }
  info.invariants.push_back({family::orthogonality, "Q Q^T = I", ""});
  info.side = side;
  info.momentum = "M";
  info.velocity = "Omega";
  return info;
}

void report_rigid_fields(StackedObservables& observables, const Scene& scene,
                         const RigidForm& form) {
  const int N = scene.dimension();
  if (observables.fields().back().name != "M")
    observables.field({"M", N, N}, [M = form.M](const auto& x, auto out) { out = M(x); });
  observables.field({"Omega", N, N},
                    [M = form.M, lambda = scene.inertia()](const auto& x, auto out) {
                      out = inverse_inertia<double>(lambda, M(x));
                    });
  if (form.scaled)
    observables.field({"epsilon", 1, 1},
                      [epsilon = scene.epsilon()](const auto&, auto out) { out(0, 0) = epsilon; });
}

void report_rigid_invariants(StackedObservables& observables, const Scene& scene, RigidForm form) {
  const Eigen::VectorXd& lambda = scene.inertia();
  observables.all_invariants = [=, discrete = scene.method().empty(), h = scene.step()](
                                   const Eigen::MatrixXd& x, InvariantList& out) {
    const Eigen::MatrixXd Q = form.Q(x), M = form.M(x);
    rigid_body_invariants(form.side, lambda, Q, M, out, form.terms ? form.terms(x) : 0);
    if (form.A && out.wants(family::PQt)) {
      const Eigen::MatrixXd A = form.A(x);
      out.add_elements(family::PQt, A, A.norm());
    }
    if (discrete) add_discrete_hamiltonian(lambda, M, h, out);
  };
  observables.frame_defect = [Q = form.Q](const Eigen::MatrixXd& x) {
    const Eigen::MatrixXd frame = Q(x);
    return frame.size() > 0 ? std::optional(orthogonality_defect(frame)) : std::nullopt;
  };
  observables.speed = [lambda, M = form.M](const Eigen::MatrixXd& x) {
    return angular_velocity_norm(lambda, M(x));
  };
}

}  // namespace stiefel
