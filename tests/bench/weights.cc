// Steps of every method on every system in several sizes, for callgrind to count one by one: before
// each it prints "system method order arithmetic scalar n N steps". tests/bench/weights.py reads
// both.
#include <iostream>

#include "engine/simulation/catalogue/methods/step_weight.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_frame.h"

using namespace stiefel;

/// The function that callgrind counts, one dump for each call.
extern "C" [[gnu::noinline]] void measured_steps(Simulation& simulation, std::int64_t steps) {
  simulation.advance(steps);
}

namespace {

constexpr double h_Omega = 0.1;

struct Size {
  int n, N;
};

/// A system on V(n, N), the momentum and costate forms too.
SceneDescription frames(const std::string& system, Size size, bool round) {
  const testing::RandomFrame<double> frame(size.n, size.N, 1, round ? 1 : 4);
  SceneDescription d;
  d.system = system;
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  const bool vector = system == "ellipsoid";
  d.initial[vector ? "q" : "Q"] = frame.Q;
  if (vector)
    d.initial["qdot"] = Eigen::MatrixXd(frame.S * frame.lambda.cwiseInverse().asDiagonal());
  if (system == "stiefel") d.initial["S"] = frame.S;
  if (system == "stiefel_costate") d.initial["P"] = frame.S;
  if (system == "stiefel_momentum")
    d.initial["M"] = Eigen::MatrixXd(frame.Q.transpose() * frame.S - frame.S.transpose() * frame.Q);
  d.step = h_Omega;
  return d;
}

std::vector<Size> sizes(const std::string& system) {
  const SystemEntry& entry = *system_entry(system);
  if (entry.example) {
    const Scene one = Scene::resolve(testing::any_scene(system, "", 1, h_Omega)).value();
    const auto [n, N] = entry.size ? entry.size(one) : frame_size(one);
    return {{static_cast<int>(n), static_cast<int>(N)}};
  }
  if (system == "double_bracket") return {{2, 3}};
  if (system == "parametric_rigid_body") return {{4, 4}};
  if (system == "ellipsoid") return {{1, 3}, {1, 8}, {1, 32}};
  if (system.starts_with("stiefel"))
    return {{1, 4}, {1, 32}, {2, 5}, {3, 3}, {3, 12}, {4, 32}, {8, 40}};
  return {{3, 3}, {4, 4}, {6, 6}, {12, 12}, {32, 32}};
}

/// A closed form exists only for Λ of at most two values.
SceneDescription scene(const std::string& system, const std::string& method, Size size) {
  const bool closed_form = catalogue().method(method)->orders.empty();
  if (system == "ellipsoid" || system.starts_with("stiefel"))
    return frames(system, size, closed_form);
  return testing::any_scene(system, closed_form ? method : "", 1, h_Omega, size.N);
}

void count(SceneDescription description, Size size) {
  const auto scene = Scene::resolve(std::move(description));
  if (!scene) return;  // the method is for other sizes
  const auto simulation = make_simulation(*scene);
  constexpr int first = 16, steps = 4;  // by then solvers have their history
  if (!simulation->advance(first).reached()) return;
  const std::int64_t before = simulation->map_steps();
  measured_steps(*simulation, steps);
  std::cout << scene->system() << ' ' << scene->method() << ' ' << scene->order() << ' '
            << scene->description().method->arithmetic << ' ' << scene->description().method->scalar
            << ' ' << size.n << ' ' << size.N << ' ' << simulation->map_steps() - before << '\n';
}

/// In every order, arithmetic and scalar; a closed form has none.
void count(std::string_view system, std::string_view method, std::optional<int> order,
           const char* arithmetic, const char* scalar) {
  for (const Size size : sizes(std::string(system))) {
    SceneDescription d = scene(std::string(system), std::string(method), size);
    d.method = MethodDescription{std::string(method), order, 1, arithmetic, {}, scalar};
    count(std::move(d), size);
  }
}

}  // namespace

int main() {
  for (const auto& system : catalogue().systems) {
    if (system.discrete) continue;
    for (const auto& on : system.methods) {
      const auto& orders = catalogue().method(on.method)->orders;
      for (const int order : orders)
        for (const char* arithmetic : {"compensated", "plain"}) {
          count(system.name, on.method, order, arithmetic, "double");
          if (on.in_float) count(system.name, on.method, order, arithmetic, "float");
        }
      if (orders.empty()) count(system.name, on.method, std::nullopt, "compensated", "double");
    }
  }
}
