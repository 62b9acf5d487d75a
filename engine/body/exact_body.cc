#include "engine/body/body_by_method.h"

#include <algorithm>

#include "engine/body/exact/euler_top.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_body_observables.h"
#include "engine/methods/exact.h"
#include "engine/motion/make_simulation_by.h"
#include "engine/motion/moves_to_times.h"
#include "engine/motion/observed_simulation.h"
#include "engine/scene/given_body.h"

namespace stiefel {
namespace {

std::span<const double> numbers(const Eigen::MatrixXd& point) {
  return {point.data(), static_cast<std::size_t>(point.size())};
}

/// Returns (q; m) of a point, with q = 1 where it has no frame.
TopInTime::WidePoint padded(std::span<const double> point) {
  TopInTime::WidePoint x;
  x << 1, 0, 0, 0, 0, 0, 0;
  std::ranges::copy(point, x.data() + x.size() - point.size());
  return x;
}

/// A state is the point and the number of steps of the map.
class ExactBody final : public ObservedSimulation, public MovesToTimes {
 public:
  explicit ExactBody(const Scene& scene)
      : ObservedSimulation(scene, rigid_body_observables(scene)),
        h_(scene.step() / scene.substeps()),
        x_(observables_->start(scene)),
        top_(top_in_time(scene, numbers(x_))) {}

  bool direct() const override { return true; }
  std::int64_t map_steps() const override { return map_steps_; }

  std::size_t saved_size() const override { return numbers(x_).size() + 1; }
  void save(std::span<double> out) const override {
    *std::ranges::copy(numbers(x_), out.begin()).out = k_;
  }
  void restore(std::int64_t step, std::span<const double> saved) override {
    std::copy_n(saved.begin(), x_.size(), x_.data());
    k_ = saved.back();
    step_ = step;
  }

  std::optional<double> largest_step(double) const override { return std::nullopt; }

  RunStatus move_to(std::span<const double> times) override { return take(top_.at(times)); }

 private:
  const Eigen::MatrixXd& point() const override { return x_; }

  RunStatus walk(std::int64_t steps, const std::stop_token&) override {
    if (steps == 0) return {};
    const long double k = static_cast<long double>(step_ + steps) * substeps_;
    const RunStatus status = take(top_.at(k, h_));
    if (!status.reached()) return status;
    step_ += steps;
    k_ = static_cast<double>(k);
    return status;
  }

  RunStatus take(const TopInTime::Point& x) {
    ++map_steps_;
    if (!x.allFinite()) return {Outcome::not_finite, std::nullopt};
    x_ = x.tail(x_.size());
    return {};
  }

  void undo() override {}

  std::optional<Eigen::MatrixXd> mapped(const Eigen::MatrixXd& point) const override {
    const auto x = top_.from(padded(numbers(point))).at(1, h_);
    if (!x.allFinite()) return std::nullopt;
    return x.tail(point.size());
  }
  bool has_all_substeps(double) const override { return true; }

  double h_;
  Eigen::MatrixXd x_;
  double k_ = 0;
  TopInTime top_;
};

}  // namespace

bool is_exact_body(const Scene& scene) {
  return scene.dimension() == 3 && scene.method() == Exact::traits.name;
}

std::unique_ptr<Simulation> exact_body(const Scene& scene) {
  return std::make_unique<ExactBody>(scene);
}

TopInTime top_in_time(const Scene& scene, std::span<const double> state) {
  const auto x = padded(state);
  const auto body = scene.axes() ? extended_body(scene) : std::nullopt;
  if (!body) return {PrincipalMoments3<Quad>(scene.inertia()), x};
  const auto& [moments, differences] = body->inertia;
  return {{moments.cast<Quad>(), differences.cast<Quad>()}, x, body->axes, body->momentum_tail};
}

}  // namespace stiefel
