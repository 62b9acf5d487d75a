#include <Eigen/Eigenvalues>

#include "engine/catalogue/system_entry.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/stacked_observables.h"

namespace stiefel {
namespace {

/// Brockett's double bracket flow (Brockett 1991) of a symmetric H, a system without frame and
/// momentum:
///
///     H' = [[D, H], H],   D = diag(d).
///
/// It keeps the eigenvalues of H, tr(DH) never falls, and H is at rest where it is diagonal.
template <class Scalar_>
class Brockett {
 public:
  static constexpr const char* name = "brockett";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  explicit Brockett(Vector<Scalar> d) : d_(std::move(d)) {}

  void field(const State& H, State& dH) {
    bracket_ = d_.asDiagonal() * H;
    bracket_ -= H * d_.asDiagonal();
    dH.noalias() = bracket_ * H;
    dH.noalias() -= H * bracket_;
  }

 private:
  Vector<Scalar> d_;
  State bracket_;
};

std::unique_ptr<Simulation> make_brockett(const Scene& scene) {
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

Simulations brockett_simulations() { return {make_brockett, methods_on<Brockett<double>>}; }

}  // namespace stiefel
