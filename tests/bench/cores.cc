// Measures how the time of a call falls with the threads that share it, 1, 2, 4 ... to as many as
// this machine has cores: an ensemble's beginning and its steps, one large body, one long frame.
// Arguments: repeats, members, N of the largest body, columns of the longest frame.
#include <Eigen/QR>
#include <functional>
#include <random>
#include <stdexcept>
#include <thread>

#include "engine/numbers/parallel.h"
#include "stiefel/crew.h"
#include "stiefel/simulation.h"
#include "stiefel/summary.h"
#include "tests/bench/measure.h"

namespace {

using namespace stiefel;

constexpr double least_seconds = 0.02;  // of a measurement

/// A figure for any number of threads. `measure` returns its value on the threads of the library.
struct Case {
  std::string name, unit;
  std::function<double()> measure;
};

RowMatrix normal(Eigen::Index rows, Eigen::Index cols) {
  static std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  return RowMatrix::NullaryExpr(rows, cols, [&] { return normal(random); });
}

Scene ensemble(int members, const MethodDescription& method) {
  RowMatrix omega = normal(members, 3);
  omega.rowwise().normalize();
  SceneDescription d;
  d.system = "rigid_body";
  d.method = method;
  d.step = 0.05;
  d.members = members;
  d.body = {{}, {1, 2, 3}, {}, {omega.data(), omega.data() + omega.size()}};
  return Scene::resolve(std::move(d)).value();
}

Scene body(int N, double h_omega) {
  const RowMatrix A = normal(N, N);
  const Eigen::VectorXd lambda = Eigen::VectorXd::LinSpaced(N, 1, 3);
  RowMatrix Omega = A - A.transpose();
  Omega *= h_omega / (4 * std::sqrt(N / 2.0));  // a random skew matrix A − Aᵀ has ‖·‖ ≈ √(8N)
  SceneDescription d;
  d.system = "rigid_body";
  d.method = {"variational", 2, 1, "plain"};
  d.step = 1;
  d.inertia = {lambda.begin(), lambda.end()};
  d.initial["Q"] = RowMatrix(RowMatrix::Identity(N, N));
  d.initial["M"] = RowMatrix(Omega * lambda.asDiagonal() + lambda.asDiagonal() * Omega);
  return Scene::resolve(std::move(d)).value();
}

/// Q with random orthonormal rows, and S = VΛ with a random tangent vector V of norm about √n.
Scene frame(int n, int N) {
  const Eigen::MatrixXd tall = normal(N, n);
  const Eigen::MatrixXd Q =
      (Eigen::HouseholderQR<Eigen::MatrixXd>(tall).householderQ() * Eigen::MatrixXd::Identity(N, n))
          .transpose();
  Eigen::MatrixXd V = normal(n, N) / std::sqrt(N);
  V -= (V * Q.transpose() + Q * V.transpose()) / 2 * Q;
  const Eigen::VectorXd lambda = Eigen::VectorXd::LinSpaced(N, 1, 2);
  SceneDescription d;
  d.system = "stiefel";
  d.method = {"variational", 2, 1, "plain"};
  d.step = 0.01;
  d.inertia = {lambda.begin(), lambda.end()};
  d.initial["Q"] = Q;
  d.initial["S"] = V * lambda.asDiagonal();
  return Scene::resolve(std::move(d)).value();
}

/// Returns the seconds of one of the calls of `work`, as many as take `least_seconds`.
double seconds_each(const std::function<void(int calls)>& work) {
  for (int calls = 1;; calls *= 2)
    if (const double time = bench::seconds([&] { work(calls); }); time > least_seconds)
      return time / calls;
}

double step_seconds(Simulation& simulation) {
  return seconds_each([&](int steps) {
    if (!simulation.advance(steps).reached()) throw std::runtime_error("a step failed");
  });
}

/// A summary of one step, from the scene on: what a member needs before its first step, and what
/// becomes of its results.
Case beginning(int members, const MethodDescription& method) {
  const auto scene = std::make_shared<Scene>(ensemble(members, method));
  SummaryDescription what;
  what.quantities.push_back({"angular_velocity", {Statistic::last}});
  what.to = what.every = 1;
  return {"a summary of one step, " + method.name, "us a member", [=] {
            return 1e6 / members * bench::seconds([&] {
                     const auto summary = Summary::prepare(*scene, what).value();
                     while (!summary->done()) summary->advance(1e9, 1, {});
                     if (summary->statistics().empty()) throw std::runtime_error("no statistics");
                   });
          }};
}

Case steps_of_ensemble(int members, const MethodDescription& method) {
  const std::shared_ptr<Simulation> all = make_simulation(ensemble(members, method));
  return {std::to_string(members) + " bodies, " + method.name + " " + method.arithmetic,
          "ns a body-step", [=] { return 1e9 / members * step_seconds(*all); }};
}

Case steps_of_body(int N, double h_omega) {
  const std::shared_ptr<Simulation> one = make_simulation(body(N, h_omega));
  if (!one->advance(16).reached()) throw std::runtime_error("a step failed");  // warms the solver
  return {"N = " + std::to_string(N) + ", h|Omega| = " + std::to_string(h_omega).substr(0, 4),
          "ms a step", [=] { return 1e3 * step_seconds(*one); }};
}

/// Copies Q and S, 8 × N numbers, on the threads of the library.
double copy_seconds(const Eigen::MatrixXd& from, Eigen::MatrixXd& to) {
  return seconds_each([&](int times) {
    for (int i = 0; i < times; ++i)
      in_ranges(from.cols(), 16, 10.0 * static_cast<double>(from.cols()),
                [&](Eigen::Index begin, Eigen::Index end) {
                  to.middleCols(begin, end - begin) = from.middleCols(begin, end - begin);
                });
  });
}

std::vector<int> thread_counts() {
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  std::vector<int> counts;
  for (int t = 1; t <= std::max(cores, 1); t *= 2) counts.push_back(t);
  return counts;
}

std::string on(int threads) { return ", " + std::to_string(threads) + " threads"; }

void compare(const Case& one, int repeats) {
  std::vector<double> alone;
  for (const int threads : thread_counts()) {
    limit_threads(threads);
    bench::Comparison c{one.name + on(threads), one.unit, "one thread"};
    for (int i = 0; i < repeats; ++i) {
      const double time = one.measure();
      if (threads == 1) alone.push_back(time);
      c.add(time, alone[static_cast<std::size_t>(i)]);
    }
    report(c);
  }
}

void compare_with_copying(int N, int repeats) {
  const auto simulation = make_simulation(frame(4, N));
  const Eigen::MatrixXd from = Eigen::MatrixXd::Random(8, N);
  Eigen::MatrixXd to = from;
  for (const int threads : thread_counts()) {
    limit_threads(threads);
    bench::Comparison c{"V(4, " + std::to_string(N) + ")" + on(threads), "ms a step",
                        "copying Q and S on as many"};
    for (int i = 0; i < repeats; ++i)
      c.add(1e3 * step_seconds(*simulation), 1e3 * copy_seconds(from, to));
    report(c);
  }
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[1]), members = std::stoi(argv[2]);
  const int largest = std::stoi(argv[3]), columns = std::stoi(argv[4]);
  for (const char* name : {"variational", "rk4", "preprocessed_variational", "exact"})
    compare(beginning(members, {name, {}, {}, ""}), repeats);
  compare(steps_of_ensemble(members, {"rk4", {}, {}, "plain"}), repeats);
  compare(steps_of_ensemble(members, {"variational", 2, {}, "compensated"}), repeats);
  for (const int N : {largest / 4, largest / 2, largest})
    for (const double h_omega : {0.05, 0.2}) compare(steps_of_body(N, h_omega), repeats);
  for (const int N : {columns / 5, columns}) compare_with_copying(N, repeats);
}
