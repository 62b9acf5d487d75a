#include "engine/motion/joint_motion.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "engine/motion/system_entry.h"
#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Number of steps that packed bodies make between two checks for a stop request.
constexpr std::int64_t between_looks = 4096;

constexpr std::size_t most_lanes = 32;  // PackedBodies::Progress has a bit for each
constexpr double of_simulation = 4000;  // nanoseconds, to make a small one

}  // namespace

JointMotion::JointMotion(const Scene& scene, std::shared_ptr<const FlatBodies> flat,
                         std::size_t first, std::size_t count, std::unique_ptr<Simulation> made)
    : scene_(scene), flat_(std::move(flat)), members_(count), simulations_(count) {
  std::iota(members_.begin(), members_.end(), first);
  if (made) simulations_.front() = std::move(made);
  form_groups();
}

Scene JointMotion::scene(std::size_t i) const {
  return scene_.members().empty() ? scene_ : scene_.members()[members_[i]];
}

void JointMotion::form_groups() {
  std::vector<char> can_be_packed(size());
  if (flat_)
    for (std::size_t i = 0; i < size(); ++i) can_be_packed[i] = flat_->can_be_packed(members_[i]);
  const auto begins = static_cast<double>(std::ranges::count(can_be_packed, false));
  if (begins > 0)
    for_each_in_parallel(std::span(simulations_), of_simulation * begins, [&](auto& one) {
      const auto i = static_cast<std::size_t>(&one - simulations_.data());
      if (can_be_packed[i]) return;
      stop_point();
      if (scene_.members().empty()) {
        if (!one) one = make_simulation(scene_);
        return;
      }
      const Scene its = scene(i);
      can_be_packed[i] = !flat_ && stiefel::can_be_packed(its);
      if (!one) one = make_simulation(its);
    });
  if (size() > 0) each_saved_ = first().saved_size();
  const auto together = static_cast<std::size_t>(std::ranges::count(can_be_packed, true));
  const auto lanes = static_cast<std::size_t>(together == 0 ? 1
                                              : flat_       ? flat_->lanes()
                                                            : body_lanes(scene_));
  grouped_.clear();
  for (const bool packed : {true, false})
    for (std::size_t i = 0; i < size(); ++i)
      if (can_be_packed[i] == packed) grouped_.push_back(i);
  const std::size_t packs = (together + lanes - 1) / lanes, alone = size() - together;
  numbers_ = std::make_unique_for_overwrite<double[]>(each_saved_ * (2 * packs * lanes + alone));
  double *now = numbers_.get(), *before = now + each_saved_ * packs * lanes;
  groups_ = std::vector<Group>(packs + alone);
  place_.resize(size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    const bool packed = g < packs;
    const std::size_t first = packed ? lanes * g : together + g - packs;
    group.members =
        std::span(grouped_).subspan(first, packed ? std::min(lanes, together - first) : 1);
    group.states = {now, packed ? each_saved_ * lanes : 0};
    group.before = {before, packed ? each_saved_ * lanes : each_saved_};
    now += group.states.size();
    before += group.before.size();
    for (std::size_t k = 0; k < group.members.size(); ++k) place_[group.members[k]] = {g, k};
  }
  for_each_in_parallel(std::span(groups_).first(packs), of_simulation * static_cast<double>(packs),
                       [&](Group& group) { pack(group); });
}

void JointMotion::pack(Group& group) const {
  const std::size_t count = group.members.size();
  if (flat_) {
    std::array<std::size_t, most_lanes> indices;
    std::ranges::transform(group.members, indices.begin(), [&](auto i) { return members_[i]; });
    group.packed = flat_->pack(std::span(indices).first(count));
    for (std::size_t k = 0; k < count; ++k) flat_->start(indices[k], lane(group, k));
  } else {
    std::vector<Scene> scenes;
    for (const std::size_t i : group.members) scenes.push_back(scene(i));
    for (std::size_t k = 0; k < count; ++k) {
      const Simulation& one = *simulations_[group.members[k]];
      one.step() == 0 ? one.save(lane(group, k)) : make_simulation(scenes[k])->save(lane(group, k));
    }
    group.packed =
        system_entry(scene_.system())->packs->make(scenes, group.states.first(each_saved_ * count));
  }
  fill_lanes(group);
}

void JointMotion::fill_lanes(Group& group) const {
  for (std::size_t k = group.members.size(); k * each_saved_ < group.states.size(); ++k)
    std::ranges::copy(lane(group, group.members.size() - 1), lane(group, k).begin());
}

std::size_t JointMotion::packed() const {
  std::size_t count = 0;
  for (const Group& group : groups_) count += group.packed ? group.members.size() : 0;
  return count;
}

std::int64_t JointMotion::map_steps() const {
  std::int64_t all = map_steps_before_;
  for (const auto& one : simulations_) all += one ? one->map_steps() : 0;
  for (const Group& group : groups_) all += group.map_steps;
  return all;
}

JointMotion::Reached JointMotion::advance(Group& group, std::int64_t steps,
                                          const std::stop_token& stop) {
  const std::int64_t from = group.step;
  Reached reached;
  if (!group.packed) {
    reached.member = group.members.front();
    reached.status = simulations_[reached.member]->advance(steps, stop);
    group.step = simulations_[reached.member]->step();
  } else {
    std::ranges::copy(group.states, group.before.begin());
    bool torn = false;
    reached = advance_packed(group, steps, stop, torn);
    const std::int64_t all = group.step - from;
    if (torn) turn_back(group, from);
    if (torn && reached.status.outcome != Outcome::cancelled) advance_packed(group, all, {}, torn);
    if (flat_)
      for (const std::size_t i : group.members) drop_simulation(i);
  }
  reached.steps = group.step - from;
  return reached;
}

JointMotion::Reached JointMotion::advance_packed(Group& group, std::int64_t steps,
                                                 const std::stop_token& stop, bool& torn) {
  const bool direct = first().direct();
  const std::int64_t at_once = direct ? steps : 1;  // a closed form makes all steps as one
  Reached out;
  for (const std::int64_t end = group.step + steps; group.step < end;) {
    if (stop.stop_requested()) {
      out.status.outcome = Outcome::cancelled;
      return out;
    }
    const std::int64_t some = direct ? steps : std::min(end - group.step, between_looks);
    const auto [taken, further] = group.packed->advance(group.states, some);
    group.step += taken;
    group.map_steps += taken / at_once * static_cast<std::int64_t>(group.members.size());
    if (taken == some) continue;
    for (std::size_t k = 0; k < group.members.size(); ++k) {
      if (further >> k & 1) continue;
      out.member = group.members[k];
      Simulation& alone = simulation(out.member);
      out.status = alone.advance(at_once, stop);
      torn = !out.status.reached();
      if (torn) return out;
      alone.save(lane(group, k));
    }
    fill_lanes(group);
    group.step += at_once;
  }
  return out;
}

void JointMotion::save(std::size_t i, std::span<double> out) const {
  if (is_packed(i))
    std::ranges::copy(state(i), out.begin());
  else
    simulations_[i]->save(out);
}

void JointMotion::restore(std::size_t i, std::int64_t step, std::span<const double> saved) {
  Group& group = groups_[place_[i].group];
  group.step = step;
  if (!group.packed) return simulations_[i]->restore(step, saved);
  std::ranges::copy(saved, lane(group, place_[i].lane).begin());
  if (i == group.members.back()) fill_lanes(group);
}

void JointMotion::keep(Group& group) const {
  if (group.packed) return;
  simulations_[group.members.front()]->save(group.before);
}

void JointMotion::turn_back(Group& group, std::int64_t step) {
  group.step = step;
  if (group.packed)
    std::ranges::copy(group.before, group.states.begin());
  else
    simulations_[group.members.front()]->restore(step, group.before);
}

Simulation& JointMotion::simulation(std::size_t i) const {
  auto& one = simulations_[i];
  if (!one) one = make_simulation(scene(i));
  if (is_packed(i)) one->restore(step(i), state(i));
  return *one;
}

void JointMotion::drop_simulation(std::size_t i) {
  if (!simulations_[i]) return;
  groups_[place_[i].group].map_steps += simulations_[i]->map_steps();
  simulations_[i].reset();
}

std::span<const std::unique_ptr<Simulation>> JointMotion::simulations() const {
  for (std::size_t i = 0; i < size(); ++i) simulation(i);
  return simulations_;
}

const Simulation& JointMotion::read(std::size_t i) const {
  return flat_ && is_packed(i) ? read(i, step(i), state(i)) : simulation(i);
}

const Simulation& JointMotion::read(std::size_t i, std::int64_t step,
                                    std::span<const double> saved) const {
  if (flat_ && is_packed(i)) {
    if (!reader_) reader_ = std::make_unique<FlatReader>(flat_);
    reader_->go_to(members_[i], step, saved);
    return *reader_;
  }
  other_ = make_simulation(scene(i));
  other_->restore(step, saved);
  return *other_;
}

void JointMotion::write(const Group& group, std::size_t index, std::size_t each,
                        std::span<double> out) const {
  for (const std::size_t i : group.members) {
    const auto to = out.subspan(each * i, each);
    if (flat_ && group.packed)
      flat_->write(members_[i], state(i), index, to);
    else
      simulation(i).write(index, to);
  }
}

void JointMotion::leave(Group& group, std::size_t i) {
  const std::vector<double> states(group.states.begin(), group.states.end());
  const std::size_t gone = place_[i].lane;
  std::ranges::copy(group.members.subspan(gone + 1), group.members.subspan(gone).begin());
  group.members = group.members.first(group.members.size() - 1);
  if (!group.packed || group.members.empty()) return;
  pack(group);
  for (std::size_t k = 0; k < group.members.size(); ++k) {
    place_[group.members[k]].lane = k;
    std::copy_n(states.begin() + static_cast<std::ptrdiff_t>(each_saved_ * (k + (k >= gone))),
                each_saved_, lane(group, k).begin());
  }
  fill_lanes(group);
}

void JointMotion::keep_members(const std::function<bool(std::size_t index)>& stays) {
  std::vector<double> saved;
  std::size_t left = 0;
  std::int64_t now = 0;
  map_steps_before_ = map_steps();
  for (std::size_t i = 0; i < size(); ++i) {
    if (!stays(members_[i])) continue;
    now = step(i);
    saved.resize(each_saved_ * (left + 1));
    save(i, std::span(saved).last(each_saved_));
    members_[left] = members_[i];
    simulations_[left++] = std::move(simulations_[i]);
  }
  members_.resize(left);
  simulations_.resize(left);
  for (const auto& one : simulations_) map_steps_before_ -= one ? one->map_steps() : 0;
  form_groups();
  for (std::size_t i = 0; i < left; ++i)
    restore(i, now, std::span(saved).subspan(each_saved_ * i, each_saved_));
}

}  // namespace stiefel
