#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tests/support/scenes/two_frames.h"

/// connect_survey [pairs = 200] [restarts = 4]: prints how many random pairs of frames are joined
/// to 1e-11, the worst residual, how often a later start found a shorter geodesic than the first,
/// and how many geodesics were seen for a pair. Exit status 1 when fewer than 99 % of any row are
/// joined.
int main(int argc, char** argv) {
  using namespace stiefel;
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 200,
            restarts = argc > 2 ? std::atoi(argv[2]) : 4;
  bool enough = true;
  std::printf("%-8s %6s %8s %9s %14s %9s\n", "frames", "1:", "joined", "residual", "later shorter",
              "distinct");
  for (const auto& [n, N] : {std::pair(1, 3), {2, 5}, {3, 8}, {5, 5}})
    for (const double spread : {4.0, 100.0}) {
      int joined = 0, later = 0, distinct = 0;
      double residual = 0;
      for (int seed = 1; seed <= pairs; ++seed) {
        TwoPointProblem problem =
            testing::random_frames(n, N, spread, static_cast<std::uint64_t>(seed));
        problem.restarts = restarts;
        const auto answer = connect(problem);
        if (!answer) {
          std::printf("  not joined: seed %d, refusal %zu\n", seed, answer.error().index());
          continue;
        }
        ++joined;
        later += answer->start > 0;
        distinct += answer->distinct;
        residual = std::max(residual, answer->residual);
      }
      enough = enough && 100 * joined >= 99 * pairs;
      std::printf("V(%d,%d)   %6g %4d/%3d %9.1e %14d %9.2f\n", n, N, spread, joined, pairs,
                  residual, later, static_cast<double>(distinct) / joined);
      std::fflush(stdout);
    }
  return enough ? 0 : 1;
}
