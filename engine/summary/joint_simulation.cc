#include "engine/summary/joint_simulation.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/motion/ensemble.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> simulation_of(std::span<const Scene> scenes, bool ensemble) {
  if (ensemble) return std::make_unique<Ensemble>(scenes);
  return make_simulation(scenes.front());
}

}  // namespace

JointSimulation::JointSimulation(std::span<const Scene> scenes, bool ensemble)
    : scenes_(scenes),
      ensemble_(ensemble),
      going_(scenes.size()),
      simulation_(simulation_of(scenes, ensemble)),
      direct_(simulation_->direct()),
      each_saved_(simulation_->saved_size() / scenes.size()) {
  std::iota(going_.begin(), going_.end(), 0uz);
}

const Simulation& JointSimulation::state(std::size_t i) const {
  return ensemble_ ? *simulation_->members()[i] : *simulation_;
}

RunStatus JointSimulation::advance(std::int64_t to, const std::stop_token& stop) {
  const std::int64_t map_steps_before = simulation_->map_steps();
  const RunStatus status = simulation_->advance(to - step_, stop);
  map_steps_ += simulation_->map_steps() - map_steps_before;
  const std::int64_t steps = simulation_->step() - step_;
  const std::int64_t done = direct_ ? std::min<std::int64_t>(steps, 1) : steps;
  computed_ += done * static_cast<std::int64_t>(going_.size());
  step_ = simulation_->step();
  return status;
}

void JointSimulation::save(std::span<double> out) const {
  if (!going_.empty()) simulation_->save(out);
}

void JointSimulation::restore(std::int64_t step, std::span<const double> saved) {
  simulation_->restore(step, saved);
  step_ = step;
}

void JointSimulation::resume(std::vector<std::size_t> going, std::int64_t step,
                             std::span<const double> saved) {
  going_ = std::move(going);
  if (going_.size() < scenes_.size()) rebuild();
  if (!going_.empty()) restore(step, saved);
}

void JointSimulation::remove(const std::function<bool(std::size_t)>& ended) {
  if (std::ranges::none_of(going_, ended)) return;
  std::vector<double> saved(saved_size()), kept;
  simulation_->save(saved);
  for (std::size_t i = 0; i < going_.size(); ++i) {
    if (ended(going_[i])) continue;
    const auto theirs = std::span(saved).subspan(i * each_saved_, each_saved_);
    kept.insert(kept.end(), theirs.begin(), theirs.end());
  }
  std::erase_if(going_, ended);
  rebuild();
  if (simulation_) simulation_->restore(step_, kept);
}

void JointSimulation::rebuild() {
  simulation_.reset();  // refers to remaining_
  remaining_.clear();
  for (const std::size_t b : going_) remaining_.push_back(scenes_[b]);
  if (!remaining_.empty()) simulation_ = simulation_of(remaining_, ensemble_);
}

}  // namespace stiefel
