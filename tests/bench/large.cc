// Compares one step of a large rigid body to the product of two N × N matrices: in plain
// arithmetic, where a step of rk4 and a call of the Schur solver stand beside it too, and in
// compensated arithmetic with Λ over 1 : 1e4. Arguments: repeats, N, seconds per measurement.
#include <stdexcept>

#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

// Steps after which a warm-started solver has a full history.
constexpr int warm_up = 16;

/// Returns the seconds that `work` takes once, averaged over as many calls as fit into `duration`.
template <class Work>
double seconds_of_one(double duration, Work&& work) {
  int times = 1;
  double spent = bench::processor_seconds(work);
  while (spent < duration) {
    times *= 2;
    spent = bench::processor_seconds([&] {
      for (int k = 0; k < times; ++k) work();
    });
  }
  return spent / times;
}

std::unique_ptr<Simulation> warmed_up(SceneDescription d) {
  auto simulation = make_simulation(Scene::resolve(std::move(d)).value());
  if (!simulation->advance(warm_up).reached()) throw std::runtime_error("a step failed");
  return simulation;
}

std::unique_ptr<Simulation> body(int N, double h_omega, const char* method, bool frame) {
  auto d = testing::description(testing::RandomBody(N, 1), h_omega, method, "plain");
  if (!frame) d.initial.erase("Q");
  return warmed_up(std::move(d));
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[1]), N = std::stoi(argv[2]);
  const double duration = std::stod(argv[3]);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(N, N), B = Eigen::MatrixXd::Random(N, N);
  Eigen::MatrixXd C(N, N);
  const auto product = [&] {
    C.noalias() = A * B;
    asm volatile("" : : "r"(C.data()) : "memory");
  };
  const auto step = [&](Simulation& simulation) {
    return 1e3 * seconds_of_one(duration, [&] {
             if (!simulation.advance(1).reached()) throw std::runtime_error("a step failed");
           });
  };
  const testing::RandomBody reference(N, 1), wide(N, 1, 1e4);

  for (const double h : {0.05, 0.2}) {
    const std::string of = "N = " + std::to_string(N) + ", h‖Ω‖ = " + (h < 0.1 ? "0.05" : "0.2");
    const auto row = [&](const char* what, const char* rival, double bound) {
      return bench::Comparison{.name = std::string(what) + ", plain, " + of,
                               .unit = "ms",
                               .rival = rival,
                               .bound = bound};
    };
    auto momentum = row("variational, M alone", "N x N product", h < 0.1 ? 2.5 : 5);
    auto full = row("variational, Q and M", "N x N product", h < 0.1 ? 3.5 : 6);
    auto against_rk4 = row("variational, Q and M", "rk4", 0.5);
    auto against_schur = row("variational, M alone", "Schur solver of U", 1 / 25.0);
    const auto without_Q = body(N, h, "variational", false),
               with_Q = body(N, h, "variational", true), rk4 = body(N, h, "rk4", true);
    for (int i = 0; i < repeats; ++i) {
      const double product_ms = 1e3 * seconds_of_one(duration, product);
      const double M_step = step(*without_Q), QM_step = step(*with_Q);
      momentum.add(M_step, product_ms);
      full.add(QM_step, product_ms);
      against_rk4.add(QM_step, step(*rk4));
      against_schur.add(M_step,
                        1e3 * seconds_of_one(0, [&] {
                          if (!testing::J_D_inverse_schur(reference.lambda, h * reference.M))
                            throw std::runtime_error("no solution");
                        }));
    }
    for (const auto& comparison : {momentum, full, against_rk4, against_schur}) report(comparison);
  }

  for (const double h : {0.1, 0.5}) {
    bench::Comparison row{.name = "variational, Q and M, compensated, Λ over 1 : 1e4, N = " +
                                  std::to_string(N) + ", h‖Ω‖ = " + (h < 0.2 ? "0.1" : "0.5"),
                          .unit = "ms",
                          .rival = "N x N product",
                          .bound = h < 0.2 ? 12.0 : 30.0};
    const auto simulation = warmed_up(testing::description(wide, h, "variational"));
    for (int i = 0; i < repeats; ++i) {
      const double product_ms = 1e3 * seconds_of_one(duration, product);
      row.add(step(*simulation), product_ms);
    }
    report(row);
  }
}
