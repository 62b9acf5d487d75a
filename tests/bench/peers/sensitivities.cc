// The state transition matrix of a free body over a time, by `exact`. Arguments: the moments, ω at
// the start, the time, and 1 for the derivatives by the moments too. For every line that it reads
// from stdin it writes the seconds of processor time and the matrix, row by row: (η, δm) at the end
// by (η, δm) at the start, then by I₁, I₂, I₃ at a constant m.
#include <array>
#include <iostream>

#include "stiefel/linearization.h"
#include "tests/bench/measure.h"

int main(int, char** argv) {
  using namespace stiefel;
  const auto number = [&](int k) { return std::stod(argv[k]); };
  SceneDescription description;
  description.system = "rigid_body";
  description.method.emplace();
  description.method->name = "exact";
  description.body.emplace();
  description.body->moments = {number(1), number(2), number(3)};
  description.body->angular_velocity = {number(4), number(5), number(6)};
  description.step = number(7);
  const bool by_moments = std::string(argv[8]) == "1";
  std::string line;
  while (std::getline(std::cin, line)) {
    Eigen::MatrixXd Phi;
    const double seconds = bench::processor_seconds([&] {
      const Scene scene = Scene::resolve(SceneDescription(description)).value();
      const auto motion = make_simulation(scene);
      auto tangent = Linearization::make(scene, {std::nullopt, false, by_moments, false}, *motion);
      if (tangent && (*tangent)->advance(*motion, 1).reached()) Phi = (*tangent)->vectors(*motion);
    });
    if (by_moments) {
      // ∂/∂I₁ = ½(−∂/∂λ₁ + ∂/∂λ₂ + ∂/∂λ₃) and cyclic.
      const Eigen::MatrixXd by_lambda = Phi.rightCols(3);
      Phi.rightCols(3) = by_lambda.rowwise().sum() * Eigen::RowVector3d::Constant(0.5) - by_lambda;
    }
    std::cout.precision(17);
    std::cout << seconds;
    for (const double x : Phi.reshaped<Eigen::RowMajor>()) std::cout << ' ' << x;
    std::cout << std::endl;
  }
}
