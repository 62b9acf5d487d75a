#include "engine/growth/confirmation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "engine/numbers/to_text.h"
#include "stiefel/catalogue.h"
#include "stiefel/conversion.h"
#include "stiefel/price.h"

namespace stiefel {
namespace {

constexpr int order_of_flow = std::numeric_limits<int>::max();
/// Of the orders of methods, the one for which `longest_step` is known.
constexpr int high_order = 8;

int highest_order(const MethodInfo& method) {
  return method.orders.empty() ? order_of_flow : method.orders.back();
}

/// Returns the fastest rate at which neighbours of a motion oscillate: next to a frame that moves
/// at this rate up to √(λ_max/λ_min) times as fast.
double fastest_oscillation(const Scene& scene, double rate) {
  const FrameSize size = frame_size(scene);
  const Eigen::VectorXd& lambda = scene.inertia();
  return size.n < size.N ? rate * std::sqrt(lambda.maxCoeff() / lambda.minCoeff()) : rate;
}

/// Moves the initial state of the description by `direction`, blocks stacked by rows.
bool move_aside(SceneDescription& moved, const Simulation& now, const Eigen::MatrixXd& direction) {
  if (moved.body) {
    auto& omega = moved.body->angular_velocity;
    const double size = std::copysign(
        Confirmation::distance * Eigen::Map<Eigen::Vector3d>(omega.data()).norm(), direction(0));
    const Eigen::Vector3d aside(0.6, -0.48, 0.64);
    for (std::size_t i = 0; i < 3; ++i) omega[i] += size * aside(static_cast<Eigen::Index>(i));
    return true;
  }
  Eigen::Index row = 0;
  const auto fields = std::span(now.fields()).first(now.block_count());
  std::erase_if(moved.initial, [&](const auto& given) {  // M of a scene whose states have P
    return std::ranges::find(fields, given.first, &Field::name) == fields.end();
  });
  for (const Field& field : fields) {
    RowMatrix& block = moved.initial[field.name].values;
    if (block.size() == 0) block = now.get(field.name);
    if (block.cols() != direction.cols() || row + block.rows() > direction.rows()) return false;
    block += Confirmation::distance * direction.middleRows(row, block.rows());
    row += block.rows();
  }
  return true;
}

}  // namespace

Scene confirming_scene(const Scene& scene) {
  const Catalogue& all = catalogue();
  const MethodInfo* best = all.method(scene.method());
  if (best == nullptr) return scene;
  for (const MethodOnSystem& on : all.system(scene.system())->methods) {
    const MethodInfo* method = all.method(on.method);
    if (tangent_of(scene, on.method) && (on.takes == nullptr || on.takes(scene.inertia())) &&
        highest_order(*method) > highest_order(*best))
      best = method;
  }
  MethodDescription method{std::string(best->name), {}, {}, ""};
  if (!best->orders.empty()) {
    method.order = best->orders.back();
    method.substeps = Confirmation::most_refinement * scene.substeps();
  }
  return scene.with(std::move(method)).value_or(scene);
}

std::string Confirmation::begin(const First& first) {
  constexpr const char* none = "No motion beside this one could be made that would confirm it.";
  const Scene map = confirming_scene(first.scene);
  auto here = scene_at(map, first.start);
  SceneDescription moved = here ? here->description() : SceneDescription{};
  if (!here || !move_aside(moved, first.start, first.direction)) return none;
  std::int64_t interval = first.interval;
  if (moved.method) {
    const double most = static_cast<double>(interval) * map.substeps();
    const double duration = static_cast<double>(interval) * std::abs(first.scene.step());
    double steps = map.order() == 0 ? 1 : most;
    if (map.order() == high_order)
      steps = std::ceil(duration * fastest_oscillation(first.scene, first.fastest) / longest_step);
    if (!(steps <= most))
      return "Its steps are too long to tell whether that is the flow's: those of the method must "
             "turn the fastest oscillation by at most " +
             to_text(most_refinement * longest_step) + " rad, and are " + to_text(steps / most, 2) +
             " times as long.";
    interval = static_cast<std::int64_t>(std::max(steps, 1.0));
    moved.step = first.scene.step() * static_cast<double>(first.interval) / interval;
    moved.method->substeps.reset();
    how_ = moved.method->name;
    if (map.order() > 0)
      how_ += " of order " + std::to_string(map.order()) + ", in steps of " +
              to_text(std::abs(*moved.step), 2);
  }
  const auto scene = Scene::resolve(std::move(moved), Scene::drift_tolerance);
  if (!scene) return none;
  LyapunovDescription what = first.what;
  what.from = 0;
  what.to = first.intervals * interval;
  what.interval = interval;
  motion_ = make_simulation(*scene);
  run_ = std::make_unique<LyapunovRun>(*scene, what, false);
  if (!run_->prepare(*motion_).empty() || !run_->begin(*motion_).empty()) return none;
  state_.resize(motion_->saved_size());
  motion_->save(state_);
  return {};
}

RunStatus Confirmation::advance(double steps, double step_cost, const std::stop_token& stop) {
  if (done()) return {};
  const double now = std::clamp(steps * step_cost / motion_->step_cost(), 1.0, 1e9);
  // To the end of an interval at most, whose state is kept.
  const RunStatus status = run_->advance(
      *motion_, std::min(static_cast<std::int64_t>(now), run_->interval_end() - run_->at()), stop);
  if (status.reached() && run_->at() == run_->step()) motion_->save(state_);
  return status;
}

std::vector<char> Confirmation::save() const {
  ByteWriter out;
  out.put(state_);
  const std::string bytes = out.take() + run_->save();
  return {bytes.begin(), bytes.end()};
}

bool Confirmation::restore(const std::vector<char>& saved) {
  ByteReader in(std::string_view(saved.data(), saved.size()));
  std::vector<double> state(state_.size());
  in.get(state);
  const LyapunovHeader header = LyapunovHeader::read(in);
  if (!in.sound() || header.interval != run_->interval() || header.step < run_->what().from ||
      header.step > run_->what().to)
    return false;
  motion_->restore(header.step, state);
  state_ = std::move(state);
  return run_->prepare(*motion_, header).empty() && run_->restore(in, *motion_);
}

}  // namespace stiefel
