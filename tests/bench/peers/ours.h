#pragma once

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/bench/peers/contestant.h"

namespace stiefel::bench {

inline End end_of(const Simulation& simulation) {
  const auto numbers = [&]<std::size_t n>(std::array<double, n> values, const char* field) {
    Eigen::Map<Eigen::RowVectorXd>(values.data(), n) = simulation.get(field);
    return values;
  };
  return {numbers(std::array<double, 4>(), "quaternion"),
          numbers(std::array<double, 3>(), "angular_velocity")};
}

/// Integrates a single body, or several bodies as an ensemble.
inline Answer turn(const Task& task, const MethodDescription& method, double step,
                   std::int64_t steps) {
  SceneDescription scene;
  scene.system = "rigid_body";
  scene.method = method;
  scene.step = step;
  auto& body = scene.body.emplace();
  for (const auto& [I, omega] : task.bodies) {
    body.moments.insert(body.moments.end(), I.begin(), I.end());
    body.angular_velocity.insert(body.angular_velocity.end(), omega.begin(), omega.end());
  }
  if (task.bodies.size() > 1) scene.members = static_cast<int>(task.bodies.size());
  const auto simulation = make_simulation(Scene::resolve(std::move(scene)).value());
  Answer answer{};
  answer.seconds = processor_seconds([&] {
    const RunStatus run_status = simulation->advance(steps);
    if (!run_status.reached()) throw std::runtime_error(to_sentence(run_status));
  });
  answer.work = steps * static_cast<std::int64_t>(task.bodies.size());
  if (simulation->members().empty()) answer.ends.push_back(end_of(*simulation));
  for (const auto& member : simulation->members()) answer.ends.push_back(end_of(*member));
  return answer;
}

/// Integrates with a method that takes a tolerance. Such a method restarts at every state, so the
/// step is chosen to give one state per rotation.
inline Answer turn_adaptively(const Task& task, MethodDescription method) {
  const Eigen::Vector3d omega(task.bodies.at(0).angular_velocity.data());
  const auto rotations =
      std::max(1.0, std::round(task.time * omega.norm() / (2 * std::numbers::pi)));
  method.tolerance = task.setting;
  return turn(task, method, task.time / rotations, static_cast<std::int64_t>(rotations));
}

/// Returns the contestant for a method with defaults for all but order, arithmetic and scalar.
inline Contestant contestant_of(const MethodInfo& method, int order, const std::string& arithmetic,
                                bool in_float) {
  const bool adaptive = method.default_tolerance > 0;
  MethodDescription description{std::string(method.name), {}, {}, arithmetic, {}};
  std::string name(method.name);
  if (method.orders.size() > 1) {
    description.order = order;
    name.append(" ").append(std::to_string(order));
  }
  name.append(", ").append(arithmetic);
  if (in_float) {
    description.scalar = "float";
    name.append(", float");
  }
  const auto run = [=](const Task& task) {
    return adaptive ? turn_adaptively(task, description)
                    : turn(task, description, task.time / task.setting,
                           static_cast<std::int64_t>(task.setting));
  };
  return {"stiefel", name, adaptive ? "tolerance" : "steps", "steps", run};
}

/// Returns every method of the catalogue for rigid_body, in every order, arithmetic and scalar,
/// except `exact`, which has no step to refine.
inline std::vector<Contestant> our_contestants() {
  std::vector<Contestant> contestants;
  for (const MethodOnSystem& on_system : catalogue().system("rigid_body")->methods) {
    const MethodInfo& method = *catalogue().method(on_system.method);
    if (method.name == "exact") continue;
    for (const int order : method.orders)
      for (const char* arithmetic : {"plain", "compensated"})
        for (const bool in_float : {false, true})
          if (on_system.in_float || !in_float)
            contestants.push_back(contestant_of(method, order, arithmetic, in_float));
  }
  return contestants;
}

}  // namespace stiefel::bench
