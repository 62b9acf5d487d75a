#include "tests/support/toys/brockett.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/methods/method_traits.h"
#include "engine/simulation/catalogue/motions/vector_field.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"
#include "engine/simulation/stepping/stacked_observables.h"
#include "tests/support/toys/heun.h"
#include "tests/support/toys/toys.h"

namespace stiefel::testing {
namespace {

void check(SceneDraft& draft) {
  check_no_extras(draft);
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
  const double cost = 500 + 5.0 * N * N * N;
  const Brockett<double> system(scene.inertia());
  if (scene.method() == Heun::traits.name)
    return make_simulation_by<Heun>(scene, system, shared(observables), cost);
  return make_simulation(scene, system, shared(observables), cost);
}

VectorField equations(const Scene& scene) {
  const double N = scene.dimension(), operations = 4 * N * N * (N + 1);
  const Brockett<long double> system(scene.inertia().cast<long double>());
  return vector_field(system, scene.block("H"), 0, operations);
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
  info.file = "tests/support/toys/brockett.h";
  info.blocks = {{"H", "N x N", true, "symmetric"}};
  info.fields = {{"H", "N x N", "symmetric"}};
  info.invariants = {{"eigenvalues", "of H, ascending", "Brockett 1991"}};
  info.methods = methods_on<Brockett<double>>(info);
  info.methods.push_back(declared_by<Heun, Brockett<double>>(info));
  return {
      .info = info, .check = check, .make = make, .vector_field = equations, .example = example};
}

void register_toys() {
  register_method(Heun::traits);
  register_system(brockett_entry());
  SystemEntry without_reference = brockett_entry();
  without_reference.info.name = "brockett_without_reference";
  without_reference.vector_field = nullptr;
  register_system(without_reference);
}

}  // namespace stiefel::testing
