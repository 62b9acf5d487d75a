#include "engine/simulation/summary/member_group.h"

#include <algorithm>
#include <utility>

#include "engine/simulation/run/ensemble.h"

namespace stiefel {
namespace {

/// Most numbers of states that wait to be read, so that they stay in the cache.
constexpr std::size_t most_saved = 2048;

std::unique_ptr<Simulation> simulation_of(std::span<const Scene> scenes, bool ensemble) {
  if (ensemble) return std::make_unique<Ensemble>(scenes);
  return make_simulation(scenes.front());
}

}  // namespace

MemberGroup::MemberGroup(std::span<const Scene> scenes, std::size_t first, bool ensemble,
                         const Plan& plan)
    : scenes_(scenes),
      first_(first),
      ensemble_(ensemble),
      plan_(plan),
      simulation_(simulation_of(scenes, ensemble)),
      direct_(simulation_->direct()),
      each_saved_(simulation_->saved_size() / scenes.size()),
      functions_(plan.what.events, ensemble ? *simulation_->members()[0] : *simulation_) {
  members_.reserve(scenes.size());
  std::size_t most = 0;
  for (std::size_t b = 0; b < scenes.size(); ++b) {
    alive_.push_back(b);
    Member member{&scenes[b], {}, {}, {}, {}, {}, PartialStep(scenes[b], direct_)};
    for (std::size_t q = 0; q < plan.reads.size(); ++q) {
      const Quantity& quantity = plan.what.quantities[q];
      const Plan::Read& read = plan.reads[q];
      member.readings.push_back(make_reading(scenes[b], state(b), quantity.name));
      const auto kept = static_cast<std::size_t>(quantity.quantiles.empty() ? 0 : plan.samples());
      member.accumulators.emplace_back(quantity, read.size, kept * read.size);
      most = std::max(most, read.size);
    }
    member.last.resize(plan.reads.size());
    member.events.assign(plan.what.events.size(), 0);
    members_.push_back(std::move(member));
  }
  for (std::size_t q = 0; q < plan.reads.size(); ++q)
    if (plan.reads[q].on_the_way) read_on_the_way_.push_back(q);
  values_.resize(most);
  drifts_.resize(most);
  reads_saved_ = std::ranges::all_of(members_, [&](const Member& member) {
    return std::ranges::all_of(read_on_the_way_, [&](std::size_t q) {
      return member.accumulators[q].drift_alone() && member.readings[q]->reads_saved();
    });
  });
}

void MemberGroup::start_at(std::int64_t step, std::span<const double> saved) {
  simulation_->restore(step, saved);
  step_ = step;
}

const Simulation& MemberGroup::state(std::size_t i) const {
  return ensemble_ ? *simulation_->members()[i] : *simulation_;
}

std::span<const double> MemberGroup::state_before(std::size_t i) const {
  return std::span(before_).subspan(i * each_saved_, each_saved_);
}

bool MemberGroup::waits_for_events() const {
  if (plan_.what.events.empty() || step_ < plan_.what.from) return false;
  return std::ranges::any_of(alive_, [&](std::size_t b) {
    for (std::size_t e = 0; e < plan_.what.events.size(); ++e) {
      const std::uint64_t limit = plan_.what.events[e].limit;
      if (limit == 0 || members_[b].events[e] < limit) return true;
    }
    return false;
  });
}

std::int64_t MemberGroup::next_stop(std::int64_t to) const {
  if (step_ < plan_.what.from) return std::min(to, plan_.what.from);
  if (waits_for_events()) return step_ + 1;
  std::int64_t next = to;
  if (plan_.reads_on_the_way) next = std::min(next, next_sample_);
  if (next_time_ < plan_.times.size()) {
    const Plan::Time& time = plan_.times[next_time_];
    const bool between = time.arrival > time.before && time.before > step_;
    next = std::min(next, between ? time.before : time.arrival);
  }
  return next;
}

void MemberGroup::advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
                          const std::stop_token& stop) {
  interrupted_ = false;
  stop_ = stop;
  if (step_ == plan_.what.from && !begun_) begin(first_time, states);
  while (!alive_.empty() && step_ < to) {
    if (!go_by_samples(to, stop)) return;
    if (alive_.empty() || step_ >= to) break;
    const std::int64_t next = next_stop(to);
    const bool between = next_time_ < plan_.times.size() &&
                         plan_.times[next_time_].before == step_ &&
                         plan_.times[next_time_].arrival > step_;
    before_.clear();
    if (between || waits_for_events()) {
      before_.resize(each_saved_ * alive_.size());
      simulation_->save(before_);
    }
    if (!go(next, stop)) return;
    if (step_ != next) continue;
    if (step_ == plan_.what.from)
      begin(first_time, states);
    else if (step_ > plan_.what.from)
      arrive(first_time, states);
    if (!stop.stop_requested()) continue;
    interrupted_ = true;  // the samples read last may be incomplete
    return;
  }
  while (next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= to) ++next_time_;
}

/// Advances to step `next`. Returns false on a stop request.
bool MemberGroup::go(std::int64_t next, const std::stop_token& stop) {
  const RunStatus status = simulation_->advance(next - step_, stop);
  const std::int64_t steps = simulation_->step() - step_;
  const std::int64_t done = direct_ ? std::min<std::int64_t>(steps, 1) : steps;
  computed_ += done * static_cast<std::int64_t>(alive_.size());
  step_ = simulation_->step();
  if (status.reached()) return true;
  if (status.outcome == Outcome::cancelled) {
    interrupted_ = true;
    return false;
  }
  take_saved();
  const auto stopped = static_cast<std::size_t>(status.member.value_or(0));
  RunStatus own = status;
  own.member.reset();
  finish(stopped, state(stopped), step_, own);
  regroup();
  return true;
}

bool MemberGroup::go_by_samples(std::int64_t to, const std::stop_token& stop) {
  if (!begun_ || !plan_.what.events.empty() || !plan_.reads_on_the_way) return true;
  std::int64_t end = std::min(to, plan_.what.to - 1);
  if (next_time_ < plan_.times.size()) end = std::min(end, plan_.times[next_time_].before - 1);
  if (next_sample_ > end) return true;
  make_room((end - next_sample_) / plan_.what.every + 1);
  bool stopped = false;
  while (!stopped && !alive_.empty() && next_sample_ <= end) {
    const std::int64_t next = next_sample_;
    stopped = !go(next, stop);
    if (step_ != next) continue;
    take_samples();
    next_sample_ += std::min(plan_.what.every, plan_.what.to - step_);
    if (!stop.stop_requested()) continue;
    interrupted_ = true;  // the samples read last may be incomplete
    stopped = true;
  }
  take_saved();
  saved_ = {};  // frees the memory, because there are many groups
  return !stopped;
}

void MemberGroup::make_room(std::int64_t samples) {
  if (!reads_saved_) return;
  const std::size_t size = each_saved_ * alive_.size(), most = std::max(most_saved / size, 1uz);
  saved_.resize(size * std::min(most, static_cast<std::size_t>(samples)));
}

/// Keeps the states to be read later together where that is possible: the divisions of several
/// samples then overlap.
void MemberGroup::take_samples() {
  if (!reads_saved_) {
    for (std::size_t i = 0; i < alive_.size(); ++i) take_sample(going(i), state(i));
    return;
  }
  const std::size_t size = each_saved_ * alive_.size();
  simulation_->save(std::span(saved_).subspan(waiting_ * size, size));
  if ((++waiting_ + 1) * size > saved_.size()) take_saved();
}

void MemberGroup::take_saved() {
  const std::size_t count = std::exchange(waiting_, 0);
  if (count == 0) return;
  const std::size_t size = each_saved_ * alive_.size();
  for (std::size_t i = 0; i < alive_.size(); ++i) {
    const SavedStates states{std::span(saved_).subspan(i * each_saved_), size, count};
    for (const std::size_t q : read_on_the_way_)
      going(i).accumulators[q].take_drift(count, going(i).readings[q]->largest_drift(states));
  }
}

void MemberGroup::begin(std::size_t first_time, std::span<StateAtTime> states) {
  begun_ = true;
  for (std::size_t i = 0; i < alive_.size(); ++i) {
    Member& member = going(i);
    if (!plan_.what.events.empty()) functions_.values(state(i), member.g);
    write_states(i, 1, first_time, states);
    take_sample(member, state(i));
    if (step_ == plan_.what.to) finish(i, state(i), step_, {});
  }
  next_sample_ = plan_.next_sample(step_);
  while (next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= step_) ++next_time_;
  regroup();
}

void MemberGroup::arrive(std::size_t first_time, std::span<StateAtTime> states) {
  const bool events = !plan_.what.events.empty() && !before_.empty();
  const bool times = next_time_ < plan_.times.size();
  const bool sampled = step_ == next_sample_, last = step_ == plan_.what.to;
  bool ended = last;
  for (std::size_t i = 0; i < alive_.size(); ++i) {
    const auto end = events ? report_events(i) : std::nullopt;
    if (times) write_states(i, end.value_or(1), first_time, states);
    ended = ended || end.has_value();
    if (end) continue;
    if (sampled) take_sample(going(i), state(i));
    if (last) finish(i, state(i), step_, {});
  }
  if (sampled && !last) next_sample_ += std::min(plan_.what.every, plan_.what.to - step_);
  while (next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= step_) ++next_time_;
  before_.clear();
  if (ended) regroup();
}

void MemberGroup::take_sample(Member& member, const Simulation& now) {
  for (const std::size_t q : read_on_the_way_) {
    const Plan::Read& read = plan_.reads[q];
    const auto values = std::span(values_).first(read.size);
    const auto drifts = std::span(drifts_).first(read.drift ? read.size : 0);
    member.readings[q]->read(now, values, drifts, stop_);
    member.accumulators[q].take(values, drifts);
  }
}

std::vector<MemberGroup::Found> MemberGroup::find_events(std::size_t i) {
  Member& member = going(i);
  std::vector<Found> found;
  functions_.values(state(i), g_);
  for (std::size_t e = 0; e < g_.size(); ++e) {
    const EventDescription& event = plan_.what.events[e];
    if (event.limit > 0 && member.events[e] >= event.limit) continue;
    if (!crosses(member.g[e], g_[e], event.direction)) continue;
    const auto g = [&](double fraction) -> std::optional<double> {
      const Simulation* now = member.between.at(step_ - 1, fraction, state_before(i), stop_);
      if (now == nullptr) return std::nullopt;
      return functions_.value(*now, e);
    };
    found.push_back({e, plan_.discrete ? 1 : zero_fraction(g, member.g[e], g_[e])});
  }
  member.g = g_;
  std::ranges::sort(found, {}, [](const Found& f) { return std::pair(f.fraction, f.event); });
  return found;
}

std::optional<double> MemberGroup::report_events(std::size_t i) {
  Member& member = going(i);
  for (const auto& [e, fraction] : find_events(i)) {
    const EventDescription& event = plan_.what.events[e];
    const Simulation* at = &state(i);
    if (fraction < 1)
      if (const auto* there = member.between.at(step_ - 1, fraction, state_before(i), stop_))
        at = there;
    const long double steps = static_cast<long double>(step_ - 1) + fraction;
    events_.push_back({e, step_ - 1, fraction, static_cast<double>(steps * member.scene->step()),
                       first_ + alive_[i], written(*at)});
    const std::uint64_t count = ++member.events[e];
    if (!event.terminal || count < std::max<std::uint64_t>(event.limit, 1)) continue;
    const auto before = make_simulation(*member.scene);
    before->restore(step_ - 1, state_before(i));
    finish(i, *before, step_ - 1, {}, static_cast<std::int64_t>(e));
    return fraction;
  }
  return std::nullopt;
}

std::vector<double> MemberGroup::written(const Simulation& now) const {
  std::vector<double> numbers(plan_.state_size);
  auto left = std::span(numbers);
  for (const std::size_t index : plan_.fields) {
    const auto size = static_cast<std::size_t>(now.fields()[index].size());
    now.write(index, left.first(size));
    left = left.subspan(size);
  }
  for (double& number : numbers) number = canonical(number);
  return numbers;
}

void MemberGroup::write_states(std::size_t i, double up_to, std::size_t first_time,
                               std::span<StateAtTime> states) {
  for (std::size_t j = next_time_; j < plan_.times.size() && plan_.times[j].arrival <= step_; ++j) {
    const Plan::Time& time = plan_.times[j];
    const bool between = time.arrival > time.before;
    if ((between ? time.fraction : 1) > up_to) return;
    times_reached_ = std::max(times_reached_, j + 1);
    const Simulation* now = &state(i);
    if (between && direct_)
      now = going(i).between.at_time(plan_.what.times[j], stop_);
    else if (between)
      now = going(i).between.at(time.before, time.fraction, state_before(i), stop_);
    if (now == nullptr) continue;
    const std::vector<double> numbers = written(*now);
    // Writes field after field, in each field member after member.
    auto& out = states[j - first_time].fields;
    const std::size_t members = out.size() / plan_.state_size;
    std::size_t from = 0;
    for (const std::size_t index : plan_.fields) {
      const auto size = static_cast<std::size_t>(now->fields()[index].size());
      const std::size_t to = from * members + (first_ + alive_[i]) * size;
      std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(from), size,
                  out.begin() + static_cast<std::ptrdiff_t>(to));
      from += size;
    }
  }
}

void MemberGroup::finish(std::size_t i, const Simulation& last, std::int64_t step, RunStatus status,
                         std::int64_t ended_by) {
  Member& member = going(i);
  const bool sampled = begun_ && (plan_.on_grid(step) || step == plan_.what.to);
  if (!sampled) take_sample(member, last);
  for (std::size_t q = 0; q < plan_.reads.size(); ++q) {
    member.last[q].resize(plan_.reads[q].size);
    member.readings[q]->read(last, member.last[q], {}, stop_);
    for (double& number : member.last[q]) number = canonical(number);
  }
  member.end = MemberEnd{status, step, ended_by, status.reached() ? 0 : last.rate()};
}

void MemberGroup::regroup() {
  const auto ended = [&](std::size_t b) { return members_[b].end.has_value(); };
  if (std::ranges::none_of(alive_, ended)) return;
  std::vector<double> saved(each_saved_ * alive_.size()), kept;
  simulation_->save(saved);
  std::vector<Scene> remaining;
  for (std::size_t i = 0; i < alive_.size(); ++i) {
    if (ended(alive_[i])) continue;
    const auto theirs = std::span(saved).subspan(i * each_saved_, each_saved_);
    kept.insert(kept.end(), theirs.begin(), theirs.end());
    remaining.push_back(*members_[alive_[i]].scene);
  }
  std::erase_if(alive_, ended);
  keep(std::move(remaining));
  if (simulation_) simulation_->restore(step_, kept);
}

void MemberGroup::keep(std::vector<Scene> remaining) {
  simulation_.reset();
  remaining_ = std::move(remaining);
  if (!remaining_.empty()) simulation_ = simulation_of(remaining_, ensemble_);
}

void MemberGroup::cancel() {
  for (std::size_t i = 0; i < alive_.size(); ++i)
    finish(i, state(i), step_, {Outcome::cancelled, std::nullopt});
  alive_.clear();
}

}  // namespace stiefel
