#include "tests/support/scenes/any_scene.h"

#include "engine/dense/decompositions.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::testing {
namespace {

RowMatrix rows(const Eigen::MatrixXd& A) { return A; }

/// Returns the frame after a step of the flow, computed to first order and projected onto the
/// manifold.
Eigen::MatrixXd moved(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& Qdot, double h) {
  Eigen::MatrixXd next = Q + h * Qdot;
  for (int k = 0; k < 6; ++k)
    next =
        ((3 * Eigen::MatrixXd::Identity(Q.rows(), Q.rows()) - next * next.transpose()) * next / 2)
            .eval();
  return next;
}

/// Returns whether the method is a closed form, which for N > 3 needs a Λ of at most two values.
bool exact(const SceneDescription& d) {
  return d.method && catalogue().method(d.method->name)->orders.empty();
}

void fill_rigid(SceneDescription& d, unsigned seed, int N) {
  const RandomBody body(N, seed);
  Eigen::MatrixXd Omega = body.M;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < N; ++i)
      if (i != j) Omega(i, j) /= body.lambda(i) + body.lambda(j);
  d.inertia = numbers(body.lambda);
  if (exact(d) && N > 3)
    for (std::size_t i = 0; i < d.inertia.size(); ++i) d.inertia[i] = i % 3 == 0 ? 1 : 2.5;
  d.initial["Q"] = rows(body.Q);
  if (d.system == "moser_veselov_pair") {
    d.initial["Q_prev"] = rows(body.Q);
    d.initial["Q"] = rows(moved(body.Q, body.Q * Omega, *d.step));
  } else {
    d.initial["M"] = rows(body.M);
  }
}

/// Sets Q and P with M_μ = G − G⁻¹ = hM + μΛ² for G = Q⁻¹P: G = W + (I + W²)^{1/2}, W = M_μ/2.
void fill_parametric(SceneDescription& d, unsigned seed) {
  const RandomBody body(4, seed);
  const bool discrete = d.system == "parametric_moser_veselov";
  const double mu = discrete ? 0.0005 : 0.0002;  // small, because the state grows like e^{μλt}
  const double h = discrete ? *d.step : 2 / body.M.norm();
  Eigen::MatrixXd W = h * body.M;
  W.diagonal() += mu * body.lambda.cwiseAbs2();
  W /= 2;
  const Eigen::MatrixXd root = principal_root(Eigen::MatrixXd::Identity(4, 4) + W * W);
  d.inertia = numbers(body.lambda);
  d.parameter = mu;
  d.initial["Q"] = rows(body.Q);
  d.initial["P"] = rows(body.Q * (W + root));
}

void fill_frames(SceneDescription& d, unsigned seed) {
  const bool vector = d.system == "ellipsoid";
  const RandomFrame<double> frame(vector ? 1 : 2, vector ? 4 : 5, seed, exact(d) ? 1 : 4);
  const Eigen::MatrixXd Qdot = frame.S * frame.lambda.cwiseInverse().asDiagonal();
  d.inertia = numbers(frame.lambda);
  d.initial[vector ? "q" : "Q"] = rows(frame.Q);
  if (vector) d.initial["qdot"] = rows(Qdot);
  if (d.system == "stiefel") d.initial["S"] = rows(frame.S);
  if (d.system == "stiefel_costate") d.initial["P"] = rows(frame.S + 0.3 * frame.Q);
  if (d.system == "stiefel_momentum")
    d.initial["M"] = rows(frame.Q.transpose() * frame.S - frame.S.transpose() * frame.Q);
  if (d.system == "discrete_stiefel") {
    d.initial["Q_prev"] = rows(frame.Q);
    d.initial["Q"] = rows(moved(frame.Q, Qdot, *d.step));
  }
}

void fill_double_bracket(SceneDescription& d, unsigned seed) {
  RandomMatrices<double> random(seed);
  d.inertia_u = {1, 1.7};
  d.inertia_v = {0.8, 1.3, 2.1};
  for (const char* name : {"Q", "P"})
    d.initial[name] = Block(rows(random.matrix(2, 3) / 2), rows(random.matrix(2, 3) / 2));
}

}  // namespace

SceneDescription any_scene(const std::string& system, const std::string& method, unsigned seed,
                           double step, int N) {
  const SystemEntry* entry = system_entry(system);
  const bool has_example = entry != nullptr && entry->example != nullptr;
  SceneDescription d = has_example ? entry->example(seed) : SceneDescription();
  d.system = system;
  if (!method.empty()) d.method = MethodDescription{method, {}, {}, "", {}};
  d.step = step;
  const MethodInfo* info = catalogue().method(method);
  if (info != nullptr &&
      info->default_tolerance > 0) {  // coarse, so that its errors are above rounding
    d.method->tolerance = 1e-5;
    *d.step *= 10;
  }
  if (has_example) return d;
  if (system == "double_bracket")
    fill_double_bracket(d, seed);
  else if (system.starts_with("parametric"))
    fill_parametric(d, seed);
  else if (system == "ellipsoid" || system.find("stiefel") != std::string::npos)
    fill_frames(d, seed);
  else
    fill_rigid(d, seed, N);
  return d;
}

}  // namespace stiefel::testing
