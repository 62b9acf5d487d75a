#include "engine/simulation/ensemble.h"

#include <algorithm>
#include <execution>

#include <tbb/global_control.h>

namespace stiefel {
namespace {

/// What lanes gain, roughly, for slicing.
constexpr double packed_gain = 5;

}  // namespace

Ensemble::Ensemble(std::span<const Scene> scenes) {
  members_.reserve(scenes.size());
  for (const Scene& scene : scenes) {
    members_.push_back(make_simulation(scene));
    step_cost_ += members_.back()->step_cost();
  }
  fields_ = members_.front()->fields();
  for (Field& field : fields_) field.members = static_cast<int>(scenes.size());
  block_count_ = members_.front()->block_count();
  each_saved_ = members_.front()->saved_size();
  saved_.resize(each_saved_ * scenes.size());
  form_groups(scenes);
}

void Ensemble::form_groups(std::span<const Scene> scenes) {
  const auto lanes = static_cast<std::size_t>(body_lanes());
  for (std::size_t at = 0; at < scenes.size();) {
    std::size_t count = 0;
    while (count < lanes && at + count < scenes.size() && can_be_packed(scenes[at + count]))
      ++count;
    groups_.push_back({at, std::max<std::size_t>(count, 1)});
    if (count > 1) {
      groups_.back().packed = pack_bodies(scenes.subspan(at, count));
      groups_.back().states.resize(each_saved_ * lanes);
      for (std::size_t k = 0; k < count; ++k)
        step_cost_ -= members_[at + k]->step_cost() * (1 - 1 / packed_gain);
    }
    at += groups_.back().count;
  }
}

std::int64_t Ensemble::map_steps() const {
  std::int64_t all = 0;
  for (const auto& member : members_) all += member->map_steps();
  for (const Group& group : groups_) all += group.packed_steps;
  return all;
}

Ending Ensemble::advance(std::int64_t steps) {
  if (steps == 0) return {};
  save(saved_);
  go(steps);
  const auto first = std::ranges::min_element(groups_, {}, &Group::reached);
  if (first->reached == steps) {
    step_ += steps;
    return {};
  }
  const Ending ending = first->ending;
  const std::int64_t reached = first->reached;
  restore(step_, saved_);
  go(reached);
  step_ += reached;
  return ending;
}

void Ensemble::go(std::int64_t steps) {
  std::for_each(std::execution::par, groups_.begin(), groups_.end(), [&](Group& group) {
    group.reached = steps;
    if (group.packed)
      go_packed(group, steps);
    else if (!go_alone(group, group.first, steps))
      group.reached = members_[group.first]->step() - step_;
  });
}

void Ensemble::go_packed(Group& group, std::int64_t steps) {
  const auto state = [&](std::size_t lane) {
    return std::span(group.states).subspan(each_saved_ * lane, each_saved_);
  };
  const auto lanes = group.states.size() / each_saved_;
  for (std::int64_t done = 0; done < steps;) {
    for (std::size_t k = 0; k < lanes; ++k)
      members_[group.first + std::min(k, group.count - 1)]->save(state(k));
    const auto [taken, further] = group.packed->advance(group.states, steps - done);
    done += taken;
    group.packed_steps += taken * static_cast<std::int64_t>(group.count);
    for (std::size_t k = 0; k < group.count; ++k)
      members_[group.first + k]->restore(step_ + done + (further >> k & 1), state(k));
    if (done == steps) return;
    for (std::size_t k = 0; k < group.count; ++k)
      if ((further >> k & 1) == 0 && !go_alone(group, group.first + k, 1)) {
        group.reached = done;
        return;
      }
    ++done;
  }
}

bool Ensemble::go_alone(Group& group, std::size_t index, std::int64_t steps) {
  group.ending = members_[index]->advance(steps);
  if (group.ending.reached()) return true;
  group.ending.member = static_cast<std::int64_t>(index);
  return false;
}

void Ensemble::save(std::span<double> out) const {
  for (std::size_t b = 0; b < members_.size(); ++b)
    members_[b]->save(out.subspan(each_saved_ * b, each_saved_));
}

void Ensemble::restore(std::int64_t step, std::span<const double> saved) {
  for (std::size_t b = 0; b < members_.size(); ++b)
    members_[b]->restore(step, saved.subspan(each_saved_ * b, each_saved_));
  step_ = step;
}

void Ensemble::write(std::size_t index, std::span<double> out) const {
  const auto each = static_cast<std::size_t>(members_.front()->fields()[index].size());
  for (std::size_t b = 0; b < members_.size(); ++b)
    members_[b]->write(index, out.subspan(each * b, each));
}

std::optional<double> Ensemble::orthogonality() const {
  std::optional<double> worst;
  for (const auto& member : members_) worst = std::max(worst, member->orthogonality());
  return worst;
}

double Ensemble::rate() const { return fastest().rate(); }

std::optional<double> Ensemble::largest_step(double limit) const {
  return fastest().largest_step(limit);
}

void limit_ensemble_threads(int threads) {
  static std::unique_ptr<tbb::global_control> limit;
  limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                static_cast<std::size_t>(threads));
}

const Simulation& Ensemble::fastest() const {
  return **std::ranges::max_element(members_, {}, [](const auto& one) { return one->rate(); });
}

}  // namespace stiefel
