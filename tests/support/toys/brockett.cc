#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/observables.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"

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
  Observables observables(scene.block("H"));
  observables.block("H", 0, N);
  observables.all_invariants = [](const Eigen::MatrixXd& H, InvariantList& out) {
    const Eigen::VectorXd values = symmetric_eigenvalues(H);
    for (Eigen::Index k = 0; k < values.size(); ++k)
      out.add("eigenvalues", indexed("eigenvalues", k + 1), values(k),
              values.cwiseAbs().maxCoeff());
  };
  observables.speed = [D](const Eigen::MatrixXd& H) { return (D * H - H * D).norm(); };
  return make_simulation(scene, Brockett<double>(scene.inertia()), shared(observables));
}

void check(SceneDraft& draft) {
  draft.refuse_other_numbers();
  draft.refuse_if(draft.given().body.has_value(), "body");
  draft.check_block_names();
  if (!draft.set_inertia()) return;
  const Eigen::Index N = draft.scene().dimension();
  const RowMatrix* H = draft.block("H", N, N);
  if (H == nullptr || !draft.check_size("initial.H", "max |H|", H->cwiseAbs().maxCoeff())) return;
  const double defect = (*H - H->transpose()).cwiseAbs().maxCoeff();
  if (!(defect <= draft.largest_repair() * H->cwiseAbs().maxCoeff()))
    return draft.refuse("initial.H", "max |H - Hᵀ| = " + to_text(defect), "must be symmetric");
  draft.set_block("H", (*H + H->transpose()) / 2);
}

SceneDescription example(unsigned seed) {
  SceneDescription d;
  d.inertia = {4, 3, 2, 1};
  RowMatrix H(4, 4);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j <= i; ++j) H(i, j) = H(j, i) = std::sin(seed + 3.0 * i + 5.0 * j * j);
  d.initial["H"] = H / 2;
  return d;
}

}  // namespace

SystemEntry brockett_entry() {
  SystemInfo info{};
  info.name = "brockett";
  info.summary = "Brockett's flow of symmetric matrices to diagonal ones";
  info.equations = "H' = [[D, H], H], D = diag(inertia)";
  info.source = "Brockett 1991";
  info.file = "tests/support/toys/brockett.cc";
  info.blocks = {{"H", "N x N", true, "symmetric"}};
  info.fields = {{"H", "N x N", "symmetric"}};
  info.invariants = {{"eigenvalues", "of H, ascending", "Brockett 1991"}};
  return {.info = info,
          .check = check,
          .make = make_brockett,
          .methods = methods_on<Brockett<double>>,
          .example = example};
}

}  // namespace stiefel
