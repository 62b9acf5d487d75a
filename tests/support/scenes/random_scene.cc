#include "tests/support/scenes/random_scene.h"

#include <cmath>
#include <random>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel::testing {

RandomBody::RandomBody(int N, unsigned seed, double spread) : lambda(N), Q(N, N), M(N, N) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  const auto fill = [&](Eigen::MatrixXd& A) {
    for (double& x : A.reshaped()) x = 2 * uniform() - 1;
  };
  for (double& l : lambda) l = std::pow(spread, uniform());
  lambda(0) = 1;
  lambda(N - 1) = spread;
  fill(Q);
  Q = orthonormal_columns(Q, N);
  if (determinant(Q) < 0) Q.col(0) = -Q.col(0);
  Eigen::MatrixXd Omega(N, N);
  fill(Omega);
  Omega = (Omega - Omega.transpose()).eval();
  Omega /= operator_norm(Omega);
  M = lambda.asDiagonal() * Omega + Omega * lambda.asDiagonal();
}

SceneDescription description(const RandomBody& body, double step, const std::string& method,
                             const std::string& arithmetic) {
  SceneDescription d;
  d.system = method.empty() ? "moser_veselov" : "rigid_body";
  if (!method.empty()) d.method = MethodDescription{method, {}, {}, arithmetic};
  d.inertia.assign(body.lambda.begin(), body.lambda.end());
  d.initial = {{"Q", RowMatrix(body.Q)}, {"M", RowMatrix(body.M)}};
  d.step = step;
  return d;
}

Scene random_scene(int N, unsigned seed, double step, const std::string& method,
                   const std::string& arithmetic) {
  return Scene::resolve(description(RandomBody(N, seed), step, method, arithmetic)).value();
}

}  // namespace stiefel::testing
