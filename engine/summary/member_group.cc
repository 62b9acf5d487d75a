#include "engine/summary/member_group.h"

#include <algorithm>
#include <utility>

namespace stiefel {

MemberGroup::MemberGroup(const Scene& scene, JointMotion motion, const Plan& plan)
    : first_(motion.index(0)),
      plan_(plan),
      motion_(std::move(motion)),
      direct_(motion_.first().direct()),
      events_(plan, motion_.first()),
      lasts_(motion_.size() * plan.last_size) {
  const bool single = scene.members().empty();
  const bool common =
      (single || motion_.flat()) &&
      std::ranges::all_of(plan.reads, [](const auto& read) { return read.common != nullptr; });
  members_.reserve(motion_.size());
  for (std::size_t i = 0; i < motion_.size(); ++i) {
    members_.emplace_back(scene, first_ + i, plan,
                          std::span(lasts_).subspan(plan.last_size * i, plan.last_size));
    const bool reads_alone = !common || !(single || motion_.is_packed(i));
    if (reads_alone) members_[i].make_readings(motion_.read(i), plan);
  }
  std::size_t most = 0;
  for (const Plan::Read& read : plan.reads) most = std::max(most, read.size);
  values_.resize(most);
  drifts_.resize(most);
}

void MemberGroup::start_at(std::int64_t step, std::span<const double> saved) {
  step_ = step;
  const std::size_t each = motion_.each_saved();
  for (std::size_t i = 0; i < left(); ++i) motion_.restore(i, step, saved.subspan(each * i, each));
}

LastStep MemberGroup::last_step(std::size_t i) const {
  const std::size_t each = motion_.each_saved();
  const auto before = std::span(before_);
  return {step_, motion_.read(i), before.empty() ? before : before.subspan(i * each, each)};
}

bool MemberGroup::waits_for_events() const {
  if (!events_.any() || step_ < plan_.what.from) return false;
  return std::ranges::any_of(members_,
                             [&](const Member& one) { return !one.end && events_.waits(one); });
}

std::int64_t MemberGroup::next_stop(std::int64_t to) const {
  if (step_ < plan_.what.from) return std::min(to, plan_.what.from);
  if (waits_for_events()) return step_ + 1;
  std::int64_t next = to;
  if (plan_.reads_on_the_way) next = std::min(next, next_sample_);
  if (const Plan::Time* time = next_time()) {
    const bool between = time->arrival > time->before && time->before > step_;
    next = std::min(next, between ? time->before : time->arrival);
  }
  return next;
}

void MemberGroup::advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
                          const std::stop_token& stop) {
  interrupted_ = false;
  stop_ = stop;
  first_time_ = first_time;
  states_ = states;
  if (step_ == plan_.what.from && !begun_) begin();
  while (!done() && step_ < to) {
    const std::int64_t next = next_stop(to);
    keep_states_before();
    if (!go(next, stop)) return;
    if (step_ == plan_.what.from)
      begin();
    else if (step_ > plan_.what.from)
      arrive();
    if (!stop.stop_requested()) continue;
    interrupted_ = true;  // the samples read last may be incomplete
    return;
  }
  pass_times(to);
}

void MemberGroup::keep_states_before() {
  const Plan::Time* time = next_time();
  if (time == nullptr && !events_.any()) return;
  const bool between = time != nullptr && time->before == step_ && time->arrival > step_;
  before_.clear();
  if (!between && !waits_for_events()) return;
  const std::size_t each = motion_.each_saved();
  before_.resize(each * left());
  for (std::size_t i = 0; i < left(); ++i)
    motion_.save(i, std::span(before_).subspan(each * i, each));
}

bool MemberGroup::go(std::int64_t next, const std::stop_token& stop) {
  for (JointMotion::Group& group : motion_.groups())
    if (!go(group, next, stop)) {
      interrupted_ = true;
      return false;
    }
  step_ = next;
  regroup();
  return true;
}

bool MemberGroup::go(JointMotion::Group& group, std::int64_t next, const std::stop_token& stop) {
  while (!group.members.empty() && group.step < next) {
    const auto count = static_cast<std::int64_t>(group.members.size());
    const auto [steps, status, i] = motion_.advance(group, next - group.step, stop);
    computed_ += (direct_ ? std::min<std::int64_t>(steps, 1) : steps) * count;
    if (status.reached()) continue;
    if (status.outcome == Outcome::cancelled) return false;
    finish(i, motion_.read(i), group.step, status);
    motion_.leave(group, i);
  }
  return true;
}

void MemberGroup::begin() {
  begun_ = true;
  const bool reads =
      events_.any() || next_time() || plan_.reads_on_the_way || step_ == plan_.what.to;
  for (std::size_t i = 0; reads && i < left(); ++i) {
    events_.begin(member(i), step_, motion_.read(i), stop_);
    write_states(member(i), last_step(i), 1);
    sample(member(i), motion_.read(i));
    if (step_ == plan_.what.to) finish(i, motion_.read(i), step_, {});
  }
  next_sample_ = plan_.next_sample(step_);
  pass_times(step_);
  regroup();
}

void MemberGroup::arrive() {
  const bool events = events_.any() && !before_.empty();
  const bool sampled = step_ == next_sample_, last = step_ == plan_.what.to;
  bool ended = last;
  for (std::size_t i = 0; i < left(); ++i) {
    const auto end = events ? report_events(i) : std::nullopt;
    if (next_time() != nullptr) write_states(member(i), last_step(i), end.value_or(1));
    ended = ended || end.has_value();
    if (end) continue;
    if (sampled && plan_.reads_on_the_way) sample(member(i), motion_.read(i));
    if (last) finish(i, motion_.read(i), step_, {});
  }
  if (sampled && !last) next_sample_ += std::min(plan_.what.every, plan_.what.to - step_);
  pass_times(step_);
  before_.clear();
  if (ended) regroup();
}

void MemberGroup::write_states(Member& member, const LastStep& step, double up_to) {
  for (std::size_t j = next_time_; j < plan_.times.size() && plan_.times[j].arrival <= step.to;
       ++j) {
    const Plan::Time& time = plan_.times[j];
    const bool between = time.arrival > time.before;
    if ((between ? time.fraction : 1) > up_to) return;
    times_reached_ = std::max(times_reached_, j + 1);
    const Simulation* now = &step.now;
    if (between && direct_)
      now = member.between().at_first_of(std::span(plan_.what.times).subspan(j), stop_);
    else if (between)
      now = member.between().at(time.before, time.fraction, step.before, stop_);
    if (now == nullptr) continue;
    const std::vector<double> numbers = written_fields(plan_, *now);
    // Writes field after field, in each field member after member.
    auto& out = states_[j - first_time_].fields;
    const std::size_t members = out.size() / plan_.state_size;
    std::size_t from = 0;
    for (const std::size_t field : plan_.fields) {
      const auto size = field_size(now->fields(), field);
      const std::size_t to = from * members + member.index * size;
      std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(from), size,
                  out.begin() + static_cast<std::ptrdiff_t>(to));
      from += size;
    }
  }
}

void MemberGroup::sample(Member& member, const Simulation& now) {
  for (std::size_t q = 0; q < plan_.reads.size(); ++q) {
    const Plan::Read& read = plan_.reads[q];
    if (!read.on_the_way) continue;
    const auto values = std::span(values_).first(read.size);
    const auto drifts = std::span(drifts_).first(read.drift ? read.size : 0);
    member.reading(plan_, q).read(now, values, drifts, stop_);
    member.accumulators[q].take(values, drifts);
  }
}

std::optional<double> MemberGroup::report_events(std::size_t i) {
  const LastStep step = last_step(i);
  const auto terminal = events_.report(member(i), step, stop_);
  if (!terminal) return std::nullopt;
  finish(i, motion_.read(i, step.to - 1, step.before), step.to - 1, {},
         static_cast<std::int64_t>(terminal->event));
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
  const auto stays = [&](std::size_t index) { return !members_[index - first_].end; };
  const std::size_t each = motion_.each_saved();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < left(); ++i) {
    if (!stays(motion_.index(i))) continue;
    if (!before_.empty())
      std::copy_n(before_.begin() + static_cast<std::ptrdiff_t>(each * i), each,
                  before_.begin() + static_cast<std::ptrdiff_t>(each * kept));
    ++kept;
  }
  if (kept == left()) return;
  before_.resize(before_.empty() ? 0 : each * kept);
  motion_.keep_members(stays);
}

void MemberGroup::cancel() {
  for (std::size_t i = 0; i < left(); ++i)
    if (!member(i).end)
      finish(i, motion_.read(i), motion_.step(i), {Outcome::cancelled, std::nullopt});
  regroup();
}

void MemberGroup::save(ByteWriter& out) const {
  std::vector<double> state(motion_.each_saved());
  std::size_t i = 0;
  for (const Member& member : members_) {
    member.save(out);
    if (member.end) continue;
    motion_.save(i++, state);
    out.put(state);
  }
}

void MemberGroup::restore(std::int64_t step, bool begun, ByteReader& in) {
  const std::size_t each = motion_.each_saved();
  std::vector<double> state(each), all;
  for (std::size_t b = 0; b < members_.size() && in.sound(); ++b) {
    members_[b].restore(in);
    if (members_[b].end) continue;
    in.get(state);
    all.insert(all.end(), state.begin(), state.end());
  }
  if (!in.sound()) return motion_.keep_members([](std::size_t) { return false; });
  regroup();
  start_at(step, all);
  if (done()) return;
  begun_ = begun;
  if (!begun) return;
  next_sample_ = plan_.next_sample(step);
  pass_times(step);
  for (std::size_t i = 0; i < left(); ++i) events_.begin(member(i), step, motion_.read(i), {});
}

}  // namespace stiefel
