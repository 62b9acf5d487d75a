#include <Eigen/Eigenvalues>

#include "engine/catalogue/system_entry.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/stacked_observables.h"
#include "tests/support/toys/brockett.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
  const int N = scene.dimension();
  const Eigen::MatrixXd D = scene.inertia().asDiagonal();
  StackedObservables observables(scene.block("H"));
  observables.block("H", 0, N);
  observables.all_invariants = [](const Eigen::MatrixXd& H, InvariantList& out) {
    const Eigen::VectorXd values =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues();
    for (Eigen::Index k = 0; k < values.size(); ++k)
      out.add("eigenvalues", indexed("eigenvalues", k + 1), values(k),
              values.cwiseAbs().maxCoeff());
  };
  observables.speed = [D](const Eigen::MatrixXd& H) { return (D * H - H * D).norm(); };
  return make_simulation(scene, Brockett<double>(scene.inertia()), shared(observables));
}

}  // namespace

Simulations brockett_simulations() { return {make, methods_on<Brockett<double>>}; }

}  // namespace stiefel
