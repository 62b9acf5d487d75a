#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "stiefel/lyapunov.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/spectra.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Inertia = std::vector<double>;

/// Returns a geodesic of unit speed on V(n, N) from a random frame, by steps of 0.1 or `step`.
Scene geodesic(Eigen::Index n, const Inertia& inertia, unsigned seed, double step = 0.1) {
  return testing::resolved(testing::geodesic(n, inertia, seed, step));
}

Scene body(Eigen::Index N, unsigned seed, const std::string& system = "rigid_body") {
  testing::RandomMatrices<double> random(seed);
  const Eigen::VectorXd lambda = random.lambda(N);
  const Dense M = random.skew(N);
  SceneDescription out;
  out.system = system;
  if (system == "rigid_body") out.method = MethodDescription{"variational", {}, {}, ""};
  out.inertia.assign(lambda.begin(), lambda.end());
  out.initial = {{"Q", Block(random.frame(N, N))},
                 {"M", Block((std::sqrt(2.0) * lambda.mean() / M.norm() * M).eval())}};
  out.step = 0.1;
  return testing::resolved(std::move(out));
}

/// `motion` is at `what.from` and moves to `what.to`.
std::unique_ptr<LyapunovExponents> spectrum_of(const Scene& scene, const LyapunovDescription& what,
                                               Simulation& motion) {
  auto made = LyapunovExponents::make(scene, what, motion);
  if (!made) throw std::runtime_error(made.error().front().rule);
  while (!(*made)->done())
    if (!(*made)->advance(motion, 100'000).reached()) throw std::runtime_error((*made)->reason());
  return *std::move(made);
}

std::unique_ptr<LyapunovExponents> spectrum_of(const Scene& scene,
                                               const LyapunovDescription& what) {
  return spectrum_of(scene, what, *make_simulation(scene));
}

struct Control {
  std::string name;
  int count;
  std::function<Scene(unsigned seed)> scene;
  std::int64_t to = 30'000;
};

/// What is proved to be integrable: bodies (Manakov), the discrete bodies (Moser and Veselov), n =
/// 1 (Jacobi), Λ = I (Bolsinov and Jovanović).
const Control regular[] = {
    {"bodies in three dimensions", 80, [](unsigned seed) { return body(3, seed); }},
    {"bodies in four dimensions", 80, [](unsigned seed) { return body(4, seed); }},
    {"bodies in five dimensions", 40, [](unsigned seed) { return body(5, seed); }},
    {"discrete bodies", 40, [](unsigned seed) { return body(4, seed, "moser_veselov"); }},
    {"ellipsoids", 80,
     [](unsigned seed) {
       return geodesic(1, {1, 1.5 + seed % 7, 3.0 + seed % 5, 10}, seed);
     }},
    {"round frames", 60,
     [](unsigned seed) {
       return geodesic(2, {1, 1, 1, 1, 1}, seed);
     }},
};

TEST(LyapunovForLong, RegularControlsAreNotChaotic) {
  for (const Control& control : regular) {
    int undecided = 0;
    for (unsigned seed = 1; seed <= static_cast<unsigned>(control.count); ++seed) {
      const auto spectrum = spectrum_of(control.scene(seed), {.to = control.to, .count = 2});
      EXPECT_NE(spectrum->kind(), MotionKind::chaotic)
          << control.name << " " << seed << ": " << spectrum->reason();
      if (spectrum->kind() != MotionKind::undecided) continue;
      ++undecided;
      std::cout << control.name << " " << seed << ": " << spectrum->reason() << "\n";
    }
    std::cout << control.name << ": " << undecided << " of " << control.count << " undecided\n";
    EXPECT_LE(undecided, control.count / 20) << control.name;
  }
}

/// The motion from a random frame on V(2, 4), Λ = (1, 2, 5, 10), which stays near regular ones for
/// thousands of units of time, at 120 of its steps, with other first vectors.
TEST(LyapunovForLong, TheChaoticControlIsChaotic) {
  const Scene scene = geodesic(2, {1, 2, 5, 10}, 1);
  const auto motion = make_simulation(scene);
  std::vector<double> start(motion->saved_size());
  for (unsigned k = 0; k < 120; ++k) {
    const std::int64_t from = 1000 * k;
    motion->save(start);
    const auto spectrum =
        spectrum_of(scene, {.from = from, .to = from + 100'000, .count = 2, .seed = k}, *motion);
    motion->restore(from, start);
    ASSERT_TRUE(motion->advance(1000).reached());
    EXPECT_EQ(spectrum->kind(), MotionKind::chaotic) << k << ": " << spectrum->reason();
  }
}

/// The error bars hold the exponents of a motion 50 times as long, pairs, zeros and the sum in 95 %
/// of 200 runs in a row of 800 units of time. The growth of this motion on V(3, 5) is correlated
/// over little of that: the variance of batches of 50 to 800 units, times their length, is the same
/// to 50 %.
TEST(LyapunovForLong, ErrorBarsCover) {
  const Scene scene = geodesic(3, {1, 2, 4, 7, 12}, 1, 0.2);
  const Eigen::VectorXd expected = spectrum_of(scene, {.to = 200'000})->exponents();
  constexpr int runs = 200, most = runs / 20;
  Eigen::VectorXi outside = Eigen::VectorXi::Zero(expected.size());
  int pairs = 0, sums = 0, zeros = 0;
  const auto motion = make_simulation(scene);
  for (unsigned k = 0; k < runs; ++k) {
    const std::int64_t from = motion->step();
    const auto spectrum = spectrum_of(scene, {.from = from, .to = from + 4000, .seed = k}, *motion);
    const Eigen::VectorXd lambda = spectrum->exponents(), error = spectrum->errors();
    const Eigen::Index d = lambda.size();
    for (Eigen::Index i = 0; i < d; ++i) outside(i) += std::abs(lambda(i) - expected(i)) > error(i);
    bool paired = true;
    for (Eigen::Index i = 0; i < d / 2; ++i)
      paired &= std::abs(lambda(i) + lambda(d - 1 - i)) <= std::hypot(error(i), error(d - 1 - i));
    pairs += !paired;
    sums += std::abs(lambda.sum()) > error.norm();
    // Energy and flow, the three numbers of m = QSᵀ − SQᵀ and the three rotations.
    int found = 0;
    for (Eigen::Index i = 0; i < d; ++i) found += std::abs(lambda(i)) <= error(i);
    zeros += found < 8;
  }
  std::cout << "outside: " << outside.transpose() << "; pairs " << pairs << ", sums " << sums
            << ", zeros " << zeros << " of " << runs << "\n";
  EXPECT_LE(outside.maxCoeff(), most);
  EXPECT_LE(pairs, most);
  EXPECT_LE(sums, most);
  EXPECT_LE(zeros, most);
}

/// Integrable: t·λ(t) grows no faster than ln t over three decades.
TEST(LyapunovForLong, RegularGrowthIsLogarithmic) {
  for (const Control& control : regular)
    for (const unsigned seed : {1u, 2u, 3u, 4u}) {
      const Scene scene = control.scene(seed);
      double S[4];
      for (int decade = 0; decade < 4; ++decade) {
        const auto to = static_cast<std::int64_t>(200 * std::pow(10, decade));
        const auto spectrum = spectrum_of(scene, {.to = to, .count = 1, .interval = 10});
        S[decade] = spectrum->exponents()(0) * scene.time(to);
      }
      EXPECT_LE(S[3] - S[0], 3 * std::log(10) * 1.25) << control.name << " " << seed;
    }
}

}  // namespace
}  // namespace stiefel
