#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/dense/decompositions.h"
#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"
#include "tests/extremes/twin/twin.h"

namespace stiefel::extremes {
namespace {

/// The variational step on V(n, N) follows a geodesic of a modified energy, so E changes by
///
///     (h²/24) tr(BKB) + O(h⁴),   KB + BK = −2W,   K = QΛ⁻¹Qᵀ,   W = Q̇Q̇ᵀ,
///
/// Störmer and Verlet's (h²/12) ∇²V(Q̇, Q̇) − (h²/24) |∇V|² with the constraint's force BQ for −∇V.
/// In K's eigenvectors tr(BKB) = Σ 2W_ij²/(κ_i + κ_j).
double modified_part(const Scene& scene, const Simulation& simulation) {
  const Eigen::VectorXd inverse = scene.inertia().cwiseInverse();
  const Eigen::MatrixXd Q = simulation.get("Q");
  const Eigen::MatrixXd Qdot = simulation.get("S") * inverse.asDiagonal();
  const auto [kappa, Z] = symmetric_eigen(Q * inverse.asDiagonal() * Q.transpose());
  const Eigen::MatrixXd W = Z.transpose() * Qdot * Qdot.transpose() * Z;
  double sum = 0;
  for (Eigen::Index j = 0; j < W.cols(); ++j)
    for (Eigen::Index i = 0; i < W.rows(); ++i)
      sum += 2 * W(i, j) * W(i, j) / (kappa(i) + kappa(j));
  return scene.step() * scene.step() / 24 * sum;
}

/// κ ≥ 1/λ_max and tr W ≤ 2E/λ_min.
double largest_modified_part(const Scene& scene, double E) {
  const double square = 2 * E / scene.inertia().minCoeff();
  return scene.step() * scene.step() / 24 * scene.inertia().maxCoeff() * square * square;
}

/// The largest change of E in `steps` steps, sampled every `every` steps, and that of E without its
/// modified part.
void measure_energy(unsigned seed, double h, std::int64_t steps, std::int64_t every,
                    const std::optional<std::string>& limit = {}) {
  SceneDescription d = geodesic(2, spread_inertia(5, 16), h, seed);
  d.method = MethodDescription{"variational", {}, {}, "compensated"};
  Trial done = run(d, 0);
  const Scene& scene = *done.scene;
  const Eigen::VectorXd lambda = scene.inertia(), inverse = lambda.cwiseInverse();
  double E_0 = 0, rest_0 = 0, E_moves = 0, rest_moves = 0, fastest = 0;
  for (std::int64_t k = 0; k < steps && done.run_status.reached(); k += every) {
    const Eigen::MatrixXd S = done.simulation->get("S");
    const double E = (S * inverse.asDiagonal() * S.transpose()).trace() / 2;
    const double rest = E + modified_part(scene, *done.simulation);
    if (k == 0) E_0 = E, rest_0 = rest;
    E_moves = std::max(E_moves, std::abs(E - E_0));
    rest_moves = std::max(rest_moves, std::abs(rest - rest_0));
    fastest = std::max(fastest, (S * inverse.asDiagonal()).norm());
    done.run_status = done.simulation->advance(every);
  }
  std::ostringstream name;
  name << "V(2,5), Λ over 1 : 16, seed " << seed << ", h = " << h << ", " << steps << " steps";
  Record r = record_of("energy", name.str(), d, done);
  const auto say = [&](const auto&... what) { report(r.with(what...)); };
  r.limit = limit;
  const double most = largest_modified_part(scene, E_0);
  say("energy moves", E_moves, most, "(h²/24) λ_max (2E/λ_min)², and no drift");
  if (limit) return;
  say("energy without its modified part, over that", rest_moves / E_moves,
      std::pow(h * fastest, 2) * lambda.maxCoeff() / lambda.minCoeff(),
      "(h‖Q̇‖)² λ_max/λ_min: the next order in h");
  const auto twin = make_twin(scene);
  double twin_moves = 0;
  for (std::int64_t k = 0; k < steps / 20; k += every) {
    twin->advance(every);
    twin_moves = std::max(twin_moves, std::abs(twin->energy_error()) * E_0);
  }
  say("energy moves", twin_moves, most, "(h²/24) λ_max (2E/λ_min)², and no drift");
}

/// The motions on V(2,5) with Λ over 1 : 16 are chaotic and come close to the maximum of tr(BKB).
TEST(Energy, FollowsAModifiedOne) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const double h : {0.05, 0.025, 0.0125}) {
      if (!long_form() && (seed > 1 || h != 0.025)) continue;
      measure_energy(seed, h, long_form() ? 100'000 : 5'000, 1);
    }
  if (!long_form()) return;
  for (const unsigned seed : {1u, 2u})
    measure_energy(seed, 0.1, 1'000'000, 10,
                   "(h‖Q̇‖)² λ_max/λ_min passes 1: the modified energy's series diverges "
                   "there, and the energy of a chaotic motion wanders until the step leaves its "
                   "domain; at half the step it stays");
}

}  // namespace
}  // namespace stiefel::extremes
