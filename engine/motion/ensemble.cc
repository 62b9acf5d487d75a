#include "engine/motion/ensemble.h"

#include <algorithm>
#include <limits>

#include "engine/motion/system_entry.h"
#include "engine/numbers/parallel.h"

namespace stiefel {

std::unique_ptr<Simulation> make_simulation(const Scene& scene) {
  if (!scene.members().empty()) return std::make_unique<Ensemble>(scene);
  return system_entry(scene.system())->make(scene);
}

Ensemble::Ensemble(const Scene& ensemble)
    : scene_(ensemble),
      motion_(scene_, flat_bodies(scene_), 0, scene_.members().size()),
      reached_(motion_.groups().size()),
      step_cost_(stiefel::step_cost(scene_.members().front(), motion_.first(), motion_.size(),
                                    motion_.packed())) {
  fields_ = motion_.first().fields();
  for (Field& field : fields_) field.members = static_cast<int>(motion_.size());
  block_count_ = motion_.first().block_count();
}

RunStatus Ensemble::advance(std::int64_t steps, const std::stop_token& stop) {
  if (steps == 0) return {};
  while (true)
    if (const auto status = advance_slice(steps, std::numeric_limits<double>::infinity(), stop))
      return *status;
}

std::optional<RunStatus> Ensemble::advance_slice(std::int64_t steps, double slice,
                                                 const std::stop_token& stop) {
  const auto groups = motion_.groups();
  if (!round_) {
    const double most = Rounds::steps(groups.size(), slice), all = static_cast<double>(steps);
    round_ = Round{direct() || all <= most ? steps : static_cast<std::int64_t>(most)};
  }
  const double of_group = direct() ? 1 : static_cast<double>(round_->steps);
  const auto part = rounds_.next(groups, of_group, slice);
  go(part, stop);
  rounds_.pass(part.size(), groups.size());
  for (const JointMotion::Group& group : part) {
    const JointMotion::Reached& reached = reached_[&group - groups.data()];
    if (reached.steps >= round_->steps) continue;
    // The other members go no further; in the end all go back, and then to this step.
    round_ = Round{reached.steps, reached.status, true};
    round_->status.member = static_cast<std::int64_t>(reached.member);
  }
  if (round_->again && stop.stop_requested()) {
    turn_back();
    return RunStatus{Outcome::cancelled, std::nullopt};
  }
  if (!rounds_.aligned()) return std::nullopt;
  const Round round = *round_;
  if (round.again) turn_back();
  if (round.again && round.steps > 0) {
    round_ = Round{round.steps, round.status};
    return std::nullopt;
  }
  round_.reset();
  step_ += round.steps;
  return round.status;
}

void Ensemble::turn_back() {
  if (!round_) return;
  const auto groups = motion_.groups();
  const std::size_t moved = rounds_.aligned() ? groups.size() : rounds_.passed();
  for (auto& group : groups.first(moved)) motion_.turn_back(group, step_);
  give_up_round();
}

void Ensemble::give_up_round() {
  rounds_.give_up();
  round_.reset();
}

void Ensemble::go(std::span<JointMotion::Group> groups, const std::stop_token& stop) {
  const auto all = motion_.groups();
  const double part = static_cast<double>(groups.size()) / static_cast<double>(all.size());
  const double of_group = direct() ? 1 : static_cast<double>(round_->steps);
  for_each_in_parallel(groups, part * step_cost_ * of_group, [&](JointMotion::Group& group) {
    motion_.keep(group);
    reached_[&group - all.data()] = motion_.advance(group, round_->steps, stop);
  });
}

void Ensemble::save(std::span<double> out) const {
  const std::size_t each = motion_.each_saved();
  for (std::size_t i = 0; i < motion_.size(); ++i) motion_.save(i, out.subspan(each * i, each));
}

void Ensemble::restore(std::int64_t step, std::span<const double> saved) {
  step_ = step;
  give_up_round();
  const std::size_t each = motion_.each_saved();
  for (std::size_t i = 0; i < motion_.size(); ++i)
    motion_.restore(i, step, saved.subspan(each * i, each));
}

void Ensemble::write(std::size_t index, std::span<double> out) const {
  constexpr double of_member = 100;  // nanoseconds
  const auto each = field_size(motion_.first().fields(), index);
  for_each_in_parallel(
      motion_.groups(), of_member * static_cast<double>(motion_.size()),
      [&](const JointMotion::Group& group) { motion_.write(group, index, each, out); });
}

std::optional<double> Ensemble::orthogonality() const {
  std::optional<double> worst;
  for (std::size_t i = 0; i < motion_.size(); ++i)
    worst = std::max(worst, motion_.read(i).orthogonality());
  return worst;
}

std::size_t Ensemble::fastest() const {
  std::size_t found = 0;
  double most = -1;
  for (std::size_t i = 0; i < motion_.size(); ++i)
    if (const double rate = motion_.read(i).rate(); rate > most) {
      most = rate;
      found = i;
    }
  return found;
}

}  // namespace stiefel
