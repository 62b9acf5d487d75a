#include "engine/rigid_body/discrete_hamiltonian.h"
#include "engine/stepping/invariant_list.h"

#include "engine/rigid_body/body/discrete_body_invariants.h"
#include "engine/rigid_body/moser_veselov/j_d_inverse.h"
#include "stiefel/invariant_names.h"

namespace stiefel {

void add_discrete_hamiltonian(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                              InvariantList& out) {
  if (!out.wants(family::discrete_hamiltonian)) return;
  const Eigen::MatrixXd K = h * M;
  const auto U = J_D_inverse(lambda, K);
  if (!U) return;
  // Size of its two terms.
  const double size = static_cast<double>(K.cols()) + lambda.cwiseAbs().sum();
  if (const auto H = discrete_hamiltonian<double>(lambda, K, *U))
    out.add(family::discrete_hamiltonian, *H, size);
}

}  // namespace stiefel
