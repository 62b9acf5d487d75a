#include "engine/summary/sampler.h"

#include <algorithm>
#include <utility>

namespace stiefel {
namespace {

/// Most numbers of states that wait to be read, so that they stay in the cache.
constexpr std::size_t most_saved = 2048;

}  // namespace

Sampler::Sampler(const Plan& plan, std::span<const Member> members) : plan_(plan) {
  std::size_t most = 0;
  for (std::size_t q = 0; q < plan.reads.size(); ++q) {
    if (plan.reads[q].on_the_way) quantities_.push_back(q);
    most = std::max(most, plan.reads[q].size);
  }
  values_.resize(most);
  drifts_.resize(most);
  reads_saved_ = std::ranges::all_of(members, [&](const Member& member) {
    return std::ranges::all_of(quantities_, [&](std::size_t q) {
      return member.accumulators[q].drift_alone() && member.readings[q]->reads_saved();
    });
  });
}

void Sampler::take(Member& member, const Simulation& now, const std::stop_token& stop) {
  for (const std::size_t q : quantities_) {
    const Plan::Read& read = plan_.reads[q];
    const auto values = std::span(values_).first(read.size);
    const auto drifts = std::span(drifts_).first(read.drift ? read.size : 0);
    member.readings[q]->read(now, values, drifts, stop);
    member.accumulators[q].take(values, drifts);
  }
}

void Sampler::take_all(std::span<Member> members, const JointSimulation& motion,
                       const std::stop_token& stop) {
  if (!reads_saved_) {
    for (std::size_t i = 0; i < motion.going().size(); ++i)
      take(members[motion.going()[i]], motion.state(i), stop);
    return;
  }
  const std::size_t size = motion.saved_size();
  motion.save(std::span(saved_).subspan(waiting_ * size, size));
  if ((++waiting_ + 1) * size > saved_.size()) read_waiting(members, motion);
}

void Sampler::read_waiting(std::span<Member> members, const JointSimulation& motion) {
  const std::size_t count = std::exchange(waiting_, 0);
  if (count == 0) return;
  for (std::size_t i = 0; i < motion.going().size(); ++i) {
    Member& member = members[motion.going()[i]];
    const SavedStates states{std::span(saved_).subspan(i * motion.each_saved()),
                             motion.saved_size(), count};
    for (const std::size_t q : quantities_)
      member.accumulators[q].take_drift(count, member.readings[q]->largest_drift(states));
  }
}

void Sampler::make_room(std::int64_t samples, const JointSimulation& motion) {
  if (!reads_saved_) return;
  const std::size_t size = motion.saved_size(), most = std::max(most_saved / size, 1uz);
  saved_.resize(size * std::min(most, static_cast<std::size_t>(samples)));
}

}  // namespace stiefel
