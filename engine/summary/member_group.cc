#include "engine/summary/member_group.h"

#include <algorithm>

namespace stiefel {
namespace {

std::vector<Member> make_members(std::span<const Scene> scenes, const JointSimulation& start,
                                 const Plan& plan) {
  std::vector<Member> members;
  members.reserve(scenes.size());
  for (std::size_t b = 0; b < scenes.size(); ++b)
    members.emplace_back(scenes[b], start.state(b), plan);
  return members;
}

}  // namespace

MemberGroup::MemberGroup(std::span<const Scene> scenes, std::size_t first, bool ensemble,
                         const Plan& plan)
    : first_(first),
      plan_(plan),
      motion_(scenes, ensemble),
      members_(make_members(scenes, motion_, plan)),
      sampler_(plan, members_),
      events_(plan, motion_.state(0)),
      times_(plan, motion_.direct()) {}

LastStep MemberGroup::last_step(std::size_t i) const {
  const std::size_t each = motion_.each_saved();
  const auto before = std::span(before_);
  return {step(), motion_.state(i), before.empty() ? before : before.subspan(i * each, each)};
}

bool MemberGroup::waits_for_events() const {
  return events_.any() && step() >= plan_.what.from &&
         std::ranges::any_of(motion_.going(),
                             [&](std::size_t b) { return events_.waits(members_[b]); });
}

std::int64_t MemberGroup::next_stop(std::int64_t to) const {
  if (step() < plan_.what.from) return std::min(to, plan_.what.from);
  if (waits_for_events()) return step() + 1;
  std::int64_t next = to;
  if (plan_.reads_on_the_way) next = std::min(next, next_sample_);
  if (const Plan::Time* time = times_.next()) {
    const bool between = time->arrival > time->before && time->before > step();
    next = std::min(next, between ? time->before : time->arrival);
  }
  return next;
}

void MemberGroup::advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
                          const std::stop_token& stop) {
  interrupted_ = false;
  stop_ = stop;
  times_.write_to(first_time, states);
  if (step() == plan_.what.from && !begun_) begin();
  while (!done() && step() < to) {
    if (!go_by_samples(to, stop)) return;
    if (done() || step() >= to) break;
    const std::int64_t next = next_stop(to);
    keep_states_before();
    if (!go(next, stop)) return;
    if (step() != next) continue;
    if (step() == plan_.what.from)
      begin();
    else if (step() > plan_.what.from)
      arrive();
    if (!stop.stop_requested()) continue;
    interrupted_ = true;  // the samples read last may be incomplete
    return;
  }
  times_.pass(to);
}

void MemberGroup::keep_states_before() {
  const Plan::Time* time = times_.next();
  const bool between = time != nullptr && time->before == step() && time->arrival > step();
  before_.clear();
  if (!between && !waits_for_events()) return;
  before_.resize(motion_.saved_size());
  motion_.save(before_);
}

bool MemberGroup::go(std::int64_t next, const std::stop_token& stop) {
  const RunStatus status = motion_.advance(next, stop);
  if (status.reached()) return true;
  if (status.outcome == Outcome::cancelled) {
    interrupted_ = true;
    return false;
  }
  sampler_.read_waiting(members_, motion_);
  const auto stopped = static_cast<std::size_t>(status.member.value_or(0));
  RunStatus own = status;
  own.member.reset();
  finish(stopped, motion_.state(stopped), step(), own);
  regroup();
  return true;
}

bool MemberGroup::go_by_samples(std::int64_t to, const std::stop_token& stop) {
  if (!begun_ || events_.any() || !plan_.reads_on_the_way) return true;
  std::int64_t end = std::min(to, plan_.what.to - 1);
  if (const Plan::Time* time = times_.next()) end = std::min(end, time->before - 1);
  if (next_sample_ > end) return true;
  sampler_.make_room((end - next_sample_) / plan_.what.every + 1, motion_);
  bool stopped = false;
  while (!stopped && !done() && next_sample_ <= end) {
    const std::int64_t next = next_sample_;
    stopped = !go(next, stop);
    if (step() != next) continue;
    sampler_.take_all(members_, motion_, stop_);
    next_sample_ += std::min(plan_.what.every, plan_.what.to - step());
    if (!stop.stop_requested()) continue;
    interrupted_ = true;  // the samples read last may be incomplete
    stopped = true;
  }
  sampler_.read_waiting(members_, motion_);
  sampler_.free_room();  // because there are many groups
  return !stopped;
}

void MemberGroup::begin() {
  begun_ = true;
  for (std::size_t i = 0; i < left(); ++i) {
    events_.begin(member(i), step(), motion_.state(i), stop_);
    times_.write(member(i), index(i), last_step(i), 1, stop_);
    sampler_.take(member(i), motion_.state(i), stop_);
    if (step() == plan_.what.to) finish(i, motion_.state(i), step(), {});
  }
  next_sample_ = plan_.next_sample(step());
  times_.pass(step());
  regroup();
}

void MemberGroup::arrive() {
  const bool events = events_.any() && !before_.empty();
  const bool sampled = step() == next_sample_, last = step() == plan_.what.to;
  bool ended = last;
  for (std::size_t i = 0; i < left(); ++i) {
    const auto end = events ? report_events(i) : std::nullopt;
    times_.write(member(i), index(i), last_step(i), end.value_or(1), stop_);
    ended = ended || end.has_value();
    if (end) continue;
    if (sampled) sampler_.take(member(i), motion_.state(i), stop_);
    if (last) finish(i, motion_.state(i), step(), {});
  }
  if (sampled && !last) next_sample_ += std::min(plan_.what.every, plan_.what.to - step());
  times_.pass(step());
  before_.clear();
  if (ended) regroup();
}

std::optional<double> MemberGroup::report_events(std::size_t i) {
  const LastStep step = last_step(i);
  const auto terminal = events_.report(member(i), index(i), step, stop_);
  if (!terminal) return std::nullopt;
  const auto before = make_simulation(*member(i).scene);
  before->restore(step.to - 1, step.before);
  finish(i, *before, step.to - 1, {}, static_cast<std::int64_t>(terminal->event));
  return terminal->fraction;
}

void MemberGroup::finish(std::size_t i, const Simulation& last, std::int64_t at,
                         const RunStatus& status, std::int64_t ended_by) {
  const bool sampled = begun_ && (plan_.on_grid(at) || at == plan_.what.to);
  if (!sampled) sampler_.take(member(i), last, stop_);
  const double rate = status.reached() ? 0 : last.rate();
  member(i).finish(last, {status, at, ended_by, rate}, plan_, stop_);
}

void MemberGroup::regroup() {
  motion_.remove([&](std::size_t b) { return members_[b].end.has_value(); });
}

void MemberGroup::cancel() {
  for (std::size_t i = 0; i < left(); ++i)
    finish(i, motion_.state(i), step(), {Outcome::cancelled, std::nullopt});
  motion_.remove_all();
}

}  // namespace stiefel
