#include "engine/summary/member_group.h"

#include <algorithm>
#include <utility>

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
      events_(plan, motion_.state(0)),
      times_(plan, motion_.direct()) {
  std::size_t most = 0;
  for (const Plan::Read& read : plan.reads) most = std::max(most, read.size);
  values_.resize(most);
  drifts_.resize(most);
}

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
  if (time == nullptr && !events_.any()) return;
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
  const auto stopped = static_cast<std::size_t>(status.member.value_or(0));
  RunStatus own = status;
  own.member.reset();
  finish(stopped, motion_.state(stopped), step(), own);
  regroup();
  return true;
}

void MemberGroup::begin() {
  begun_ = true;
  for (std::size_t i = 0; i < left(); ++i) {
    events_.begin(member(i), step(), motion_.state(i), stop_);
    times_.write(member(i), index(i), last_step(i), 1, stop_);
    sample(member(i), motion_.state(i));
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
    if (times_.next() != nullptr)
      times_.write(member(i), index(i), last_step(i), end.value_or(1), stop_);
    ended = ended || end.has_value();
    if (end) continue;
    if (sampled) sample(member(i), motion_.state(i));
    if (last) finish(i, motion_.state(i), step(), {});
  }
  if (sampled && !last) next_sample_ += std::min(plan_.what.every, plan_.what.to - step());
  times_.pass(step());
  before_.clear();
  if (ended) regroup();
}

void MemberGroup::sample(Member& member, const Simulation& now) {
  for (std::size_t q = 0; q < plan_.reads.size(); ++q) {
    const Plan::Read& read = plan_.reads[q];
    if (!read.on_the_way) continue;
    const auto values = std::span(values_).first(read.size);
    const auto drifts = std::span(drifts_).first(read.drift ? read.size : 0);
    member.readings[q]->read(now, values, drifts, stop_);
    member.accumulators[q].take(values, drifts);
  }
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
  if (!sampled) sample(member(i), last);
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

void MemberGroup::save(ByteWriter& out) const {
  std::vector<double> saved(motion_.saved_size());
  motion_.save(saved);
  auto waiting = std::span<const double>(saved);
  for (const Member& member : members_) {
    member.save(out);
    if (member.end) continue;
    const auto theirs = waiting.first(motion_.each_saved());
    out.put(std::vector<double>(theirs.begin(), theirs.end()));
    waiting = waiting.subspan(motion_.each_saved());
  }
}

void MemberGroup::restore(std::int64_t step, bool begun, ByteReader& in) {
  std::vector<double> state(motion_.each_saved()), all;
  std::vector<std::size_t> going;
  for (std::size_t b = 0; b < members_.size() && in.sound(); ++b) {
    members_[b].restore(plan_, in);
    if (members_[b].end) continue;
    in.get(state);
    all.insert(all.end(), state.begin(), state.end());
    going.push_back(b);
  }
  if (!in.sound()) return motion_.remove_all();
  motion_.resume(std::move(going), step, all);
  if (done()) return;
  begun_ = begun;
  if (!begun) return;
  next_sample_ = plan_.next_sample(step);
  times_.pass(step);
  for (std::size_t i = 0; i < left(); ++i) events_.begin(member(i), step, motion_.state(i), {});
}

}  // namespace stiefel
