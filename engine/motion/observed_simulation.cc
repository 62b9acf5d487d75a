#include "engine/motion/observed_simulation.h"

#include <algorithm>
#include <cmath>

#include "engine/dense/continuation.h"
#include "engine/dense/euler_angles.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Steps that take at least so many nanoseconds (5 million instructions) are slow.
constexpr double slow_step = 1e6;

}  // namespace

ObservedSimulation::ObservedSimulation(const Scene& scene, SharedObservables observables)
    : observables_(std::move(observables)),
      substeps_(scene.substeps()),
      step_of_map_(std::abs(scene.description().step.value_or(0)) / substeps_),
      step_cost_(nanoseconds(step_weight(scene)) * substeps_) {
  fields_ = observables_->fields();
  block_count_ = observables_->block_count();
}

/// An implicit method may have to follow the solution of a step with h‖Ω‖ > 1 from h = 0, which
/// takes seconds where h‖Ω‖ is a billion.
void ObservedSimulation::stop_inside_if_long(bool chooses_steps) {
  stops_inside_ = step_cost_ >= slow_step * substeps_ || chooses_steps || step_of_map_ * rate() > 1;
}

template <class Walk>
RunStatus ObservedSimulation::unless_stopped_inside(const std::stop_token& stop, const Walk& walk) {
  if (!stops_inside_) {
    const StopScope whole_steps = StopScope::nothing();
    return walk();
  }
  try {
    const StopScope scope(stop);
    return walk();
  } catch (const Stopped&) {
    undo();
    return {Outcome::cancelled, std::nullopt};
  }
}

RunStatus ObservedSimulation::advance(std::int64_t steps, const std::stop_token& stop) {
  return unless_stopped_inside(stop, [&] { return walk(steps, stop); });
}

RunStatus ObservedSimulation::move_to(std::span<const double> times, const std::stop_token& stop) {
  return unless_stopped_inside(stop, [&] { return walk_to(times); });
}

void ObservedSimulation::write_euler(std::size_t code, std::span<double> out) const {
  Eigen::Vector4d q;
  Eigen::Vector3d omega;
  const auto read = [&](std::string_view name, double* numbers, std::size_t size) {
    observables_->write(point(), *find_field(fields_, name), {numbers, size});
  };
  read("quaternion", q.data(), 4);
  read("angular_velocity", omega.data(), 3);
  Eigen::Map<Eigen::Vector3d>(out.data()) = EulerField::with_code(code).value(q, omega);
}

bool ObservedSimulation::fields_are_finite(Eigen::Index size) const {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (fields_[i].size() > 4 * size) continue;
    numbers.resize(static_cast<std::size_t>(fields_[i].size()));
    write(i, numbers);
    if (!std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); })) return false;
  }
  return true;
}

RunStatus ObservedSimulation::left_domain_of_all_substeps(RunStatus status,
                                                          const std::stop_token& stop) const {
  constexpr double longer = 1.05;
  const auto has_all = [&](double t) { return has_all_substeps(t); };
  const auto reached = unless_stopped(stop, [&] {
    double t = continuation(1, has_all);
    while (t > 0 && t < 1 && has_all(longer * t)) t *= longer;
    return t;
  });
  if (!reached) return {Outcome::cancelled, std::nullopt};
  status.largest_step.reset();
  if (*reached > 0 && *reached < 1) status.largest_step = *reached * step_of_map_;
  return status;
}

}  // namespace stiefel
