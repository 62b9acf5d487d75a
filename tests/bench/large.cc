// Compares one step of a large rigid body to the product of two N × N matrices: in plain
// arithmetic, where a step of rk4 and a call of the Schur solver stand beside it too, and in
// compensated arithmetic with Λ over 1 : 1e4. Arguments: repeats, N, seconds per measurement.
// With the argument "cores": compares a step on two threads to what two processes of one thread
// each, at the same time, reach together, for a large body, a long frame and an ensemble.
// Arguments: "cores", repeats, N, columns, seconds per measurement.
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <stdexcept>

#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/resolved.h"

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

void steps(int repeats, int N, double duration) {
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

Scene body(int N, const char* arithmetic) {
  return testing::resolved(
      testing::description(testing::RandomBody(N, 1), 0.1, "variational", arithmetic));
}

Scene frame(int N) {
  const testing::RandomFrame<double> at(4, N, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.method = {"variational", 2, 1, "compensated"};
  d.inertia = {at.lambda.begin(), at.lambda.end()};
  d.initial["Q"] = at.Q;
  d.initial["S"] = at.S;
  d.step = 0.05;
  return testing::resolved(std::move(d));
}

Scene ensemble(int members) {
  std::vector<SceneDescription> scenes;
  for (int b = 0; b < members; ++b)
    scenes.push_back(testing::description(testing::RandomBody(3, static_cast<unsigned>(b + 1)), 0.1,
                                          "variational"));
  return testing::resolved(testing::ensemble_of(scenes));
}

/// Returns the seconds that `steps` steps take, measured for `duration` after as long a start.
double step_seconds(const Scene& scene, std::int64_t steps, double duration) {
  const auto simulation = make_simulation(scene);
  const auto once = [&] {
    if (!simulation->advance(steps).reached()) throw std::runtime_error("a step failed");
  };
  for (double spent = 0; spent < duration;) spent += bench::seconds(once);
  double spent = 0;
  int times = 0;
  for (; spent < duration; ++times) spent += bench::seconds(once);
  return spent / times;
}

/// Returns step_seconds of so many processes at the same time, with that many threads each.
std::vector<double> in_processes(int processes, int threads,
                                 const std::function<double()>& measure) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  for (int k = 0; k < processes; ++k) {
    if (fork() != 0) continue;
    limit_threads(threads);
    const double seconds = measure();
    _exit(write(ends[1], &seconds, sizeof seconds) == sizeof seconds ? 0 : 1);
  }
  close(ends[1]);
  std::vector<double> all(static_cast<std::size_t>(processes));
  for (double& seconds : all)
    if (read(ends[0], &seconds, sizeof seconds) != sizeof seconds)
      throw std::runtime_error("a process failed");
  close(ends[0]);
  while (wait(nullptr) > 0) {
  }
  return all;
}

void compare(const std::string& name, const Scene& scene, std::int64_t steps, int repeats,
             double duration) {
  bench::Comparison row{.name = name + ", on two threads",
                        .unit = "ms",
                        .rival = "two processes together",
                        .bound = 1 / 0.85};
  const auto measure = [&] { return step_seconds(scene, steps, duration); };
  for (int i = 0; i < repeats; ++i) {
    const auto two = in_processes(2, 1, measure);
    const double both = 1 / (1 / two[0] + 1 / two[1]);
    row.add(1e3 * in_processes(1, 2, measure)[0], 1e3 * both);
  }
  report(row);
}

void cores(int repeats, int N, int columns, double duration) {
  for (const char* arithmetic : {"compensated", "plain"})
    compare("variational, " + std::string(arithmetic) + ", N = " + std::to_string(N),
            body(N, arithmetic), 1, repeats, duration);
  compare("V(4, N), compensated, N = " + std::to_string(columns), frame(columns), 1, repeats,
          duration);
  compare("variational, compensated, N = 3, 100 steps of an ensemble of 1024", ensemble(1024), 100,
          repeats, duration);
}

}  // namespace

int main(int, char** argv) {
  if (std::string(argv[1]) == "cores")
    cores(std::stoi(argv[2]), std::stoi(argv[3]), std::stoi(argv[4]), std::stod(argv[5]));
  else
    steps(std::stoi(argv[1]), std::stoi(argv[2]), std::stod(argv[3]));
}
