#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <string>

#include "engine/frame/geodesics/geodesic_series.h"
#include "tests/support/scenes/two_frames.h"

namespace {

using namespace stiefel;

/// A pair of frames, and the energy of a geodesic that joins them; infinite where none is known.
struct Pair {
  TwoPointProblem problem;
  double energy;
};

Pair random_pair(int n, int N, double spread, std::uint64_t seed) {
  return {testing::random_frames(n, N, spread, seed), std::numeric_limits<double>::infinity()};
}

/// Draws Q_0 and a tangent vector of a given length ‖V‖, whose geodesic ends at Q_T; again where
/// that geodesic takes too many Taylor series.
Pair drawn_pair(int n, int N, double spread, double length, std::uint64_t seed) {
  Pair pair = random_pair(n, N, spread, seed);
  TwoPointProblem& p = pair.problem;
  for (std::uint64_t next = seed + 1'000'000;; next += 1'000'000) {
    Eigen::MatrixXd V = testing::random_frames(n, N, spread, next).Q_T;
    V -= ((V * p.Q_0.transpose() + p.Q_0 * V.transpose()) / 2 * p.Q_0).eval();
    V *= length / V.norm();
    const auto end = geodesic_end(p.inertia, p.Q_0, V);
    if (!end) continue;
    p.Q_T = end->Q;
    pair.energy = (V.cwiseAbs2() * p.inertia).sum() / 2;
    return pair;
  }
}

/// Joins pairs and prints how many were joined, the worst residual, how many answers are longer and
/// shorter than the drawn geodesic, how many are proved the shortest, how many geodesics were seen,
/// and the processor time of a pair. Returns whether the part that was joined is large enough.
template <class Draw>
bool survey(const std::string& name, int pairs, int restarts, double part, Draw draw) {
  int joined = 0, longer = 0, shorter = 0, proved = 0, distinct = 0;
  double residual = 0;
  const std::clock_t start = std::clock();
  std::clock_t drawing = 0;
  for (int seed = 1; seed <= pairs; ++seed) {
    const std::clock_t before = std::clock();
    Pair pair = draw(static_cast<std::uint64_t>(seed));
    drawing += std::clock() - before;
    pair.problem.restarts = restarts;
    const auto answer = connect(pair.problem);
    if (!answer) {
      std::printf("  not joined: seed %d, refusal %zu\n", seed, answer.error().index());
      continue;
    }
    ++joined;
    longer += answer->energy > pair.energy * (1 + 1e-6);
    shorter += answer->energy < pair.energy * (1 - 1e-6);
    proved += answer->shortest == Shortest::yes;
    distinct += answer->distinct;
    residual = std::max(residual, answer->residual);
  }
  const double seconds = static_cast<double>(std::clock() - start - drawing) / CLOCKS_PER_SEC;
  std::printf("%-26s %5d/%-5d %9.1e %7d %8d %7d %9.2f %9.2f\n", name.c_str(), joined, pairs,
              residual, longer, shorter, proved,
              static_cast<double>(distinct) / std::max(joined, 1), 1e3 * seconds / pairs);
  std::fflush(stdout);
  return joined >= part * pairs;
}

}  // namespace

/// connect_survey [pairs = 200] [restarts = 0]: joins random pairs of frames, and ends of geodesics
/// of 0.5 π and 0.8 π, for Λ over 1:1 to 1:10⁴, and from 1:100 on three tenths of them. Exit
/// status 1 when too few of any row are joined.
int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 200,
            restarts = argc > 2 ? std::atoi(argv[2]) : 0;
  bool enough = true;
  std::printf("%-26s %11s %9s %7s %8s %7s %9s %9s\n", "frames", "joined", "residual", "longer",
              "shorter", "proved", "distinct", "ms");
  for (const auto& [n, N] : {std::pair(3, 8), {5, 20}, {10, 50}})
    for (const double spread : {1.0, 10.0, 100.0, 1e4})
      for (const double length : {0.5, 0.8}) {
        const double part = spread == 1 || (spread == 10 && length == 0.5) ? 0.999 : 0.99;
        const std::string name = "V(" + std::to_string(n) + "," + std::to_string(N) +
                                 ") 1:" + std::to_string(static_cast<int>(spread)) + ", " +
                                 (length < 0.6 ? "0.5 pi" : "0.8 pi");
        const int drawn = spread > 10 ? std::max(1, pairs * 3 / 10) : pairs;
        enough &= survey(name, drawn, restarts, part, [&](std::uint64_t seed) {
          return drawn_pair(n, N, spread, length * std::numbers::pi, seed);
        });
      }
  for (const auto& [n, N] : {std::pair(1, 3), {2, 5}, {3, 4}, {3, 8}, {5, 5}})
    for (const double spread : {4.0, 100.0}) {
      const std::string name = "V(" + std::to_string(n) + "," + std::to_string(N) +
                               ") 1:" + std::to_string(static_cast<int>(spread)) + ", random";
      enough &= survey(name, pairs, restarts, 0.99,
                       [&](std::uint64_t seed) { return random_pair(n, N, spread, seed); });
    }
  return enough ? 0 : 1;
}
