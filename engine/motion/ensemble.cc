#include "engine/motion/ensemble.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/motion/groups.h"
#include "engine/motion/system_entry.h"
#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Number of steps that packed bodies make between two checks for a stop request.
constexpr std::int64_t between_looks = 4096;

}  // namespace

std::unique_ptr<Simulation> make_simulation(const Scene& scene) {
  if (!scene.members().empty()) return std::make_unique<Ensemble>(scene.members());
  return system_entry(scene.system())->make(scene);
}

Ensemble::Ensemble(const Members& scenes) : members_(scenes.size()) {
  groups_ = groups_of(scenes, [this](std::span<const Scene> group, std::size_t first) {
    return form_group(group, first);
  });
  sum_up(scenes.front());
}

Ensemble::Ensemble(std::span<const Scene> group) : members_(group.size()) {
  groups_.push_back(form_group(group, 0));
  sum_up(group.front());
}

void Ensemble::sum_up(const Scene& first) {
  std::size_t packed = 0;
  for (const Group& group : groups_) packed += group.can_be_packed ? group.count : 0;
  step_cost_ = stiefel::step_cost(first, *members_.front(), members_.size(), packed);
  each_saved_ = members_.front()->saved_size();
  fields_ = members_.front()->fields();
  for (Field& field : fields_) field.members = static_cast<int>(members_.size());
  block_count_ = members_.front()->block_count();
}

Ensemble::Group Ensemble::form_group(std::span<const Scene> scenes, std::size_t first) {
  Group group{first, scenes.size(), can_be_packed(scenes[0])};
  for (std::size_t k = 0; k < group.count; ++k) members_[first + k] = make_simulation(scenes[k]);
  if (group.count == 1) return group;
  const std::size_t each = members_[first]->saved_size();
  group.states.resize(each * static_cast<std::size_t>(body_lanes(scenes[0])));
  for (std::size_t k = 0; k * each < group.states.size(); ++k)
    members_[first + std::min(k, group.count - 1)]->save(
        std::span(group.states).subspan(each * k, each));
  group.packed = system_entry(scenes[0].system())->packs->make(scenes, group.states);
  return group;
}

std::int64_t Ensemble::map_steps() const {
  std::int64_t all = 0;
  for (const auto& member : members_) all += member->map_steps();
  for (const Group& group : groups_) all += group.packed_steps;
  return all;
}

RunStatus Ensemble::advance(std::int64_t steps, const std::stop_token& stop) {
  if (steps == 0) return {};
  while (true)
    if (const auto status = advance_slice(steps, std::numeric_limits<double>::infinity(), stop))
      return *status;
}

std::optional<RunStatus> Ensemble::advance_slice(std::int64_t steps, double slice,
                                                 const std::stop_token& stop) {
  if (!round_) {
    const double most = Rounds::steps(groups_.size(), slice), all = static_cast<double>(steps);
    round_ = Round{direct() || all <= most ? steps : static_cast<std::int64_t>(most)};
  }
  const double of_group = direct() ? 1 : static_cast<double>(round_->steps);
  const auto part = rounds_.next(std::span(groups_), of_group, slice);
  go(part, stop);
  rounds_.pass(part.size(), groups_.size());
  for (const Group& group : part) {
    if (group.reached >= round_->steps) continue;
    // The other members go no further; in the end all go back, and then to this step.
    round_ = Round{group.reached, group.status, true};
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
  const std::size_t moved = rounds_.aligned() ? groups_.size() : rounds_.passed();
  for (Group& group : std::span(groups_).first(moved)) put_back(group, group.before);
  give_up_round();
}

void Ensemble::give_up_round() {
  rounds_.give_up();
  round_.reset();
}

void Ensemble::go(std::span<Group> groups, const std::stop_token& stop) {
  const std::int64_t steps = round_->steps;
  const double part = static_cast<double>(groups.size()) / static_cast<double>(groups_.size());
  const double of_group = direct() ? 1 : static_cast<double>(steps);
  for_each_in_parallel(groups, part * step_cost_ * of_group, [&](Group& group) {
    group.reached = steps;
    if (group.packed) {
      group.before = group.states;
      go_packed(group, steps, stop);
    } else {
      group.before.resize(each_saved_);
      members_[group.first]->save(group.before);
      if (!go_alone(group, group.first, steps, stop))
        group.reached = members_[group.first]->step() - step_;
    }
  });
}

void Ensemble::go_packed(Group& group, std::int64_t steps, const std::stop_token& stop) {
  group.stale = true;
  const std::int64_t at_once = direct() ? steps : 1;  // a closed form makes all steps as one
  for (std::int64_t done = 0; done < steps;) {
    group.reached = done;
    if (stop.stop_requested()) return;
    const std::int64_t some = direct() ? steps : std::min(steps - done, between_looks);
    const auto [taken, further] = group.packed->advance(group.states, some);
    done += taken;
    group.packed_steps += taken / at_once * static_cast<std::int64_t>(group.count);
    if (taken == some) continue;
    group.reached = done;
    for (std::size_t k = 0; k < group.count; ++k) {
      if (further >> k & 1) continue;
      Simulation& member = *members_[group.first + k];
      member.restore(step_ + done, state(group, k));
      if (!go_alone(group, group.first + k, at_once, stop)) return;
      member.save(state(group, k));
    }
    fill_lanes(group);
    done += at_once;
  }
  group.reached = steps;
}

bool Ensemble::go_alone(Group& group, std::size_t index, std::int64_t steps,
                        const std::stop_token& stop) {
  group.status = members_[index]->advance(steps, stop);
  if (group.status.reached()) return true;
  group.status.member = static_cast<std::int64_t>(index);
  return false;
}

std::span<double> Ensemble::state(Group& group, std::size_t lane) const {
  return std::span(group.states).subspan(each_saved_ * lane, each_saved_);
}

void Ensemble::fill_lanes(Group& group) const {
  for (std::size_t k = group.count; k * each_saved_ < group.states.size(); ++k)
    std::ranges::copy(state(group, group.count - 1), state(group, k).begin());
}

void Ensemble::put_back(Group& group, std::span<const double> states) {
  if (!group.packed) return members_[group.first]->restore(step_, states);
  std::ranges::copy(states, group.states.begin());
  fill_lanes(group);
  group.stale = true;
}

void Ensemble::bring_up_to_date(const Group& group) const {
  if (!std::exchange(group.stale, false)) return;
  const auto states = std::span(group.states);
  for (std::size_t k = 0; k < group.count; ++k)
    members_[group.first + k]->restore(step_, states.subspan(each_saved_ * k, each_saved_));
}

void Ensemble::save(std::span<double> out) const {
  for (const Group& group : groups_) {
    const auto theirs = out.subspan(each_saved_ * group.first, each_saved_ * group.count);
    if (group.packed)
      std::copy_n(group.states.begin(), theirs.size(), theirs.begin());
    else
      members_[group.first]->save(theirs);
  }
}

void Ensemble::restore(std::int64_t step, std::span<const double> saved) {
  step_ = step;
  give_up_round();
  for (Group& group : groups_)
    put_back(group, saved.subspan(each_saved_ * group.first, each_saved_ * group.count));
}

void Ensemble::write(std::size_t index, std::span<double> out) const {
  constexpr double of_member = 100;  // nanoseconds
  const auto each = field_size(members_.front()->fields(), index);
  for_each_in_parallel(std::span(groups_), of_member * static_cast<double>(members_.size()),
                       [&](const Group& group) {
                         bring_up_to_date(group);
                         for (std::size_t b = group.first; b < group.first + group.count; ++b)
                           members_[b]->write(index, out.subspan(each * b, each));
                       });
}

std::optional<double> Ensemble::orthogonality() const {
  std::optional<double> worst;
  for (const auto& member : members()) worst = std::max(worst, member->orthogonality());
  return worst;
}

double Ensemble::rate() const { return fastest().rate(); }

std::optional<double> Ensemble::largest_step(double limit) const {
  return fastest().largest_step(limit);
}

const Simulation& Ensemble::fastest() const {
  return **std::ranges::max_element(members(), {}, [](const auto& one) { return one->rate(); });
}

}  // namespace stiefel
