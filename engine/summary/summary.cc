#include "stiefel/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "engine/numbers/parallel.h"
#include "engine/run/groups.h"
#include "engine/summary/member_group.h"

namespace stiefel {
namespace {

/// Most numbers of events and states that wait to be taken; more end the slice. 16 MiB.
constexpr std::size_t most_waiting = std::size_t{1} << 21;
/// Least number of groups in a part, enough for every core, and most parts.
constexpr std::size_t least_part = 16, most_parts = 16;

std::vector<double> empty_state(std::size_t size) {
  return std::vector<double>(size, canonical(NAN));
}

}  // namespace

struct Summary::Parts {
  const Scene& scene;
  Plan plan;
  std::vector<std::vector<Scene>> scenes = {};  ///< the members of each group
  std::vector<std::unique_ptr<MemberGroup>> groups = {};
  std::size_t members = 1;
  std::size_t saved_size = 0;  ///< for one member
  bool direct = false;
  double step_cost = 0;  ///< nanoseconds for a step of all members, without the reading
  std::int64_t step = 0, computed_before = 0;
  std::int64_t round_end = 0;  ///< step to which the groups advance, one part of them after another
  std::size_t groups_at_round_end = 0;  ///< 0 also when all groups have reached it
  std::size_t next_time = 0;
  bool interrupted = false;
  std::vector<Event> events = {};
  std::vector<StateAtTime> states = {};

  void make_groups(const Simulation& start) {
    const auto all = scene.members();
    if (all.empty()) {
      step_cost = start.step_cost();
      groups.push_back(std::make_unique<MemberGroup>(std::span(&scene, 1), 0, false, plan));
      return;
    }
    members = all.size();
    std::size_t at = 0;
    for_each_group(all, [&](std::span<const Scene> together) {
      step_cost += group_cost(together, start);
      scenes.emplace_back(together.begin(), together.end());
      groups.push_back(std::make_unique<MemberGroup>(scenes.back(), at, true, plan));
      at += together.size();
    });
  }

  bool done() const {
    return std::ranges::all_of(groups, [](const auto& group) { return group->done(); });
  }

  /// Returns the number of parts in which the groups advance. With events or times it is 1: events
  /// and states are reported in the order of steps, so all groups must advance together.
  std::size_t parts() const {
    if (!plan.what.events.empty() || !plan.times.empty()) return 1;
    return std::clamp(groups.size() / least_part, std::size_t{1}, most_parts);
  }

  /// Number of groups in a part; the last part may have fewer.
  std::size_t width() const { return (groups.size() + parts() - 1) / parts(); }

  /// Returns the step at which an advance by `steps` ends.
  std::int64_t target(std::int64_t steps, std::int64_t bound) const {
    const SummaryDescription& what = plan.what;
    bound = std::min(bound, what.to);
    if (!what.events.empty()) {
      const std::size_t each = members * what.events.size() * (plan.state_size + 8);
      steps = std::min(steps, static_cast<std::int64_t>(most_waiting / each) + 1);
    } else if (direct) {
      // With a closed form, a jump of any length costs as much as a step.
      const std::int64_t jump = plan.reads_on_the_way ? what.every : what.to - step;
      if (jump > 0 && steps > (bound - step) / jump) return bound;
      steps *= std::max<std::int64_t>(jump, 1);
    }
    std::int64_t to = bound - step < steps ? bound : step + steps;
    const std::size_t most = most_waiting / std::max<std::size_t>(1, members * plan.state_size);
    if (plan.times.size() - next_time > most)
      to = std::min(
          to, std::max(plan.times[next_time + most].arrival - 1, plan.times[next_time].arrival));
    return std::max(to, step);
  }

  /// Appends empty states for the times up to step `to`, and returns them.
  std::span<StateAtTime> make_room(std::int64_t to) {
    const std::size_t first = states.size();
    for (; next_time < plan.times.size() && plan.times[next_time].arrival <= to; ++next_time)
      states.push_back({plan.times[next_time].before, plan.what.times[next_time],
                        empty_state(members * plan.state_size)});
    return std::span(states).subspan(first);
  }

  /// Removes the states at times that no member reached; called when the summary is done.
  void drop_unreached(std::size_t first_time) {
    std::size_t reached = first_time;
    for (const auto& group : groups) reached = std::max(reached, group->times_reached());
    states.resize(states.size() - (next_time - reached));
  }

  void collect_events() {
    const std::size_t before = events.size();
    for (const auto& group : groups) {
      std::ranges::move(group->events(), std::back_inserter(events));
      group->events().clear();
    }
    std::ranges::stable_sort(
        events.begin() + static_cast<std::ptrdiff_t>(before), events.end(), {},
        [](const Event& e) { return std::tuple(e.step, e.member, e.fraction, e.event); });
  }

  /// Returns the member that stopped first, or null.
  const MemberEnd* first_stop(std::size_t* index) const {
    const MemberEnd* first = nullptr;
    std::size_t at = 0;
    for (const auto& group : groups)
      for (std::size_t b = 0; b < group->size(); ++b, ++at) {
        const MemberEnd& end = group->end(b);
        if (end.status.reached() || (first && first->last_step <= end.last_step)) continue;
        first = &end;
        *index = at;
      }
    return first;
  }
};

Summary::Summary(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Summary::Summary(Summary&&) noexcept = default;
Summary::~Summary() = default;

std::expected<Summary, Violations> Summary::prepare(const Scene& scene, SummaryDescription what) {
  const auto members = scene.members();
  const auto start = members.empty() ? make_simulation(scene) : make_simulation(members.front());
  auto plan = make_plan(scene, *start, std::move(what));
  if (!plan) return std::unexpected(std::move(plan.error()));
  auto parts = std::unique_ptr<Parts>(new Parts{scene, *std::move(plan)});
  parts->direct = start->direct();
  parts->saved_size = start->saved_size();
  parts->make_groups(*start);
  return Summary(std::move(parts));
}

void Summary::start_at(std::int64_t step, std::span<const double> saved) {
  parts_->step = step;
  for (const auto& group : parts_->groups) {
    group->start_at(step, saved.first(group->saved_size()));
    saved = saved.subspan(group->saved_size());
  }
}

void Summary::advance(std::int64_t steps, std::int64_t bound, const std::stop_token& stop) {
  Parts& all = *parts_;
  const std::size_t count = all.groups.size();
  if (all.groups_at_round_end == 0) {
    constexpr auto most = std::numeric_limits<std::int64_t>::max();
    const auto times = static_cast<std::int64_t>(all.parts());
    all.round_end = all.target(steps > most / times ? most : steps * times, bound);
  }
  const std::size_t end = std::min(count, all.groups_at_round_end + all.width());
  const std::size_t first_time = all.next_time;
  const auto states = all.make_room(all.round_end);
  const std::span part =
      std::span(all.groups).subspan(all.groups_at_round_end, end - all.groups_at_round_end);
  const double share = static_cast<double>(part.size()) / static_cast<double>(count);
  const double nanoseconds = share * all.step_cost * static_cast<double>(all.round_end - all.step);
  for_each_in_parallel(part, nanoseconds, [&](const std::unique_ptr<MemberGroup>& group) {
    group->advance(all.round_end, first_time, states, stop);
  });
  all.collect_events();
  if (all.done()) all.drop_unreached(first_time);
  all.interrupted =
      std::ranges::any_of(all.groups, [](const auto& group) { return group->interrupted(); });
  if (all.interrupted) return;
  all.groups_at_round_end = end < count ? end : 0;
  if (all.groups_at_round_end == 0) all.step = all.round_end;
}

void Summary::cancel() {
  for (const auto& group : parts_->groups) group->cancel();
}

std::int64_t Summary::step() const { return parts_->step; }
bool Summary::done() const { return parts_->done(); }
bool Summary::interrupted() const { return parts_->interrupted; }
std::size_t Summary::width() const { return parts_->width(); }
bool Summary::aligned() const { return !parts_->interrupted && parts_->groups_at_round_end == 0; }

std::vector<Event> Summary::take_events() { return std::exchange(parts_->events, {}); }
std::vector<StateAtTime> Summary::take_states() { return std::exchange(parts_->states, {}); }

RunStatus Summary::status() const {
  std::size_t member = 0;
  const MemberEnd* first = parts_->first_stop(&member);
  if (first == nullptr) return {};
  RunStatus status = first->status;
  if (!parts_->scene.members().empty()) status.member = static_cast<std::int64_t>(member);
  return status;
}

double Summary::rate() const {
  std::size_t member = 0;
  const MemberEnd* first = parts_->first_stop(&member);
  return first == nullptr ? 0 : first->rate;
}

std::vector<SummaryArray> Summary::statistics() const {
  std::vector<const MemberGroup*> groups;
  for (const auto& group : parts_->groups) groups.push_back(group.get());
  return results(parts_->plan, groups, !parts_->scene.members().empty());
}

std::uint64_t Summary::statistics_bytes() const {
  return result_bytes(parts_->plan, parts_->members);
}

std::string Summary::save() const {
  ByteWriter out;
  const auto going =
      std::ranges::find_if(parts_->groups, [](const auto& group) { return !group->done(); });
  out.put(parts_->step);
  out.put(computed_steps());
  out.put(going != parts_->groups.end() && (*going)->begun());
  for (const auto& group : parts_->groups) group->save(out);
  return out.take();
}

bool Summary::restore(std::string_view saved) {
  ByteReader in(saved);
  Parts& all = *parts_;
  bool begun = false;
  std::int64_t step = 0, computed = 0;
  in.get(step);
  in.get(computed);
  in.get(begun);
  if (!in.sound() || step < 0 || step > all.plan.what.to) return false;
  for (const auto& group : all.groups) group->restore(step, begun, in);
  const bool outside = begun ? step < all.plan.what.from : step > all.plan.what.from;
  if (!in.complete() || (outside && !all.done())) return false;
  all.step = step;
  all.computed_before = computed;
  while (begun && all.next_time < all.plan.times.size() &&
         all.plan.times[all.next_time].arrival <= step)
    ++all.next_time;
  return true;
}

std::int64_t Summary::computed_steps() const {
  std::int64_t sum = parts_->computed_before;
  for (const auto& group : parts_->groups) sum += group->computed_steps();
  return sum;
}

std::int64_t Summary::map_steps() const {
  std::int64_t sum = 0;
  for (const auto& group : parts_->groups) sum += group->map_steps();
  return sum;
}

bool Summary::reads_on_the_way() const {
  return parts_->plan.reads_on_the_way || !parts_->plan.what.events.empty();
}

const SummaryDescription& Summary::description() const { return parts_->plan.what; }

}  // namespace stiefel
