#include "engine/simulation/catalogue/families/discrete_hamiltonian.h"
#include "engine/simulation/stepping/invariant_list.h"

#include "engine/invariants/discrete_rigid_body.h"
#include "engine/representations/j_d_inverse.h"
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
