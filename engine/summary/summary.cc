#include "stiefel/summary.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/motion/ensemble.h"
#include "engine/motion/rounds.h"
#include "engine/numbers/parallel.h"
#include "engine/summary/member_group.h"

namespace stiefel {
namespace {

/// Most numbers of events and states that wait to be taken; more end the slice. 16 MiB.
constexpr std::size_t most_waiting = std::size_t{1} << 21;

constexpr double of_body = 200, of_member = 8000;  ///< nanoseconds to begin

std::vector<double> empty_state(std::size_t size) {
  return std::vector<double>(size, canonical(NAN));
}

}  // namespace

struct Summary::Parts {
  const Scene& scene;
  Plan plan;
  std::vector<std::unique_ptr<MemberGroup>> groups = {};
  std::size_t members = 1;
  bool direct = false;
  double step_cost = 0;  ///< nanoseconds for a step of all members, without the reading
  std::int64_t step = 0, computed_before = 0;
  Rounds rounds = {};
  bool in_round = false;       ///< whether some groups are to advance to `round_end`
  std::int64_t round_end = 0;  ///< step to which the groups advance, one part of them after another
  std::size_t next_time = 0, first_time = 0, first_state = 0;  ///< the first ones of the round
  bool interrupted = false;
  std::vector<Event> events = {};
  std::vector<StateAtTime> states = {};

  void make_groups(const Simulation& start, const std::shared_ptr<const FlatBodies>& flat) {
    if (scene.members().empty()) {
      step_cost = start.step_cost();
      groups.push_back(std::make_unique<MemberGroup>(scene, nullptr, 0, 1, plan));
      return;
    }
    members = scene.members().size();
    const Scene first = scene.members().front();
    const std::size_t size = group_size(first, flat.get());
    groups.resize((members + size - 1) / size);
    const double nanoseconds = static_cast<double>(members) * (flat ? of_body : of_member);
    for_each_in_parallel(std::span(groups), nanoseconds, [&](auto& group) {
      const std::size_t from = size * static_cast<std::size_t>(&group - groups.data());
      group =
          std::make_unique<MemberGroup>(scene, flat, from, std::min(size, members - from), plan);
    });
    std::size_t packed = 0;
    for (const auto& group : groups) packed += group->packed();
    step_cost = stiefel::step_cost(first, start, members, packed);
  }

  /// Returns how many members a group has: as many packs as leave enough groups to divide.
  std::size_t group_size(const Scene& first, const FlatBodies* flat) const {
    constexpr std::size_t least_groups = 64, most_packs = 16;
    if (!flat) return can_be_packed(first) ? static_cast<std::size_t>(body_lanes(first)) : 1;
    const auto lanes = static_cast<std::size_t>(flat->lanes());
    return lanes * std::clamp(members / (lanes * least_groups), std::size_t{1}, most_packs);
  }

  bool done() const {
    return !in_round &&
           std::ranges::all_of(groups, [](const auto& group) { return group->done(); });
  }

  /// Returns how many steps of a closed form are computed as one.
  std::int64_t jump() const {
    const std::int64_t jump = plan.reads_on_the_way ? plan.what.every : plan.what.to - step;
    return direct && plan.what.events.empty() ? std::max<std::int64_t>(jump, 1) : 1;
  }

  /// Returns the step at which a round ends that begins with a slice of so many steps.
  std::int64_t target(double slice, std::int64_t bound) const {
    const SummaryDescription& what = plan.what;
    bound = std::min(bound, what.to);
    double steps = Rounds::steps(groups.size(), slice);
    if (!what.events.empty()) {
      const std::size_t each = members * what.events.size() * (plan.state_size + 8);
      steps = std::min(steps, static_cast<double>(most_waiting / each + 1));
    }
    steps = std::floor(steps) * static_cast<double>(jump());
    std::int64_t to =
        steps < static_cast<double>(bound - step) ? step + static_cast<std::int64_t>(steps) : bound;
    const std::size_t most = most_waiting / std::max<std::size_t>(1, members * plan.state_size);
    if (plan.times.size() - next_time > most)
      to = std::min(
          to, std::max(plan.times[next_time + most].arrival - 1, plan.times[next_time].arrival));
    return std::max(to, step);
  }

  /// Returns the steps of the round, those of a jump as one.
  double round_steps() const {
    return std::ceil(static_cast<double>(round_end - step) / static_cast<double>(jump()));
  }

  /// Begins a round with a slice of so many steps, and appends empty states for its times.
  void begin_round(double slice, std::int64_t bound) {
    in_round = true;
    round_end = target(slice, bound);
    first_time = next_time;
    first_state = states.size();
    for (; next_time < plan.times.size() && plan.times[next_time].arrival <= round_end; ++next_time)
      states.push_back({plan.times[next_time].before, plan.what.times[next_time],
                        empty_state(members * plan.state_size)});
  }

  void end_round() {
    in_round = false;
    step = round_end;
    collect_events();
    if (done()) drop_unreached();
  }

  /// Removes the states at times that no member reached; called when the summary is done.
  void drop_unreached() {
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

std::expected<Summary, Violations> Summary::prepare(const Scene& scene, SummaryDescription what,
                                                    const Simulation* begun) {
  const auto members = scene.members();
  const auto* ensemble = dynamic_cast<const Ensemble*>(begun);
  const auto flat = ensemble ? ensemble->flat() : flat_bodies(scene);
  const auto start = members.empty() ? make_simulation(scene) : make_simulation(members.front());
  auto plan = make_plan(scene, *start, std::move(what));
  if (!plan) return std::unexpected(std::move(plan.error()));
  auto parts = std::unique_ptr<Parts>(new Parts{scene, *std::move(plan)});
  parts->direct = start->direct();
  parts->make_groups(*start, flat);
  return Summary(std::move(parts));
}

void Summary::start_at(std::int64_t step, std::span<const double> saved) {
  parts_->step = step;
  for (const auto& group : parts_->groups) {
    group->start_at(step, saved.first(group->saved_size()));
    saved = saved.subspan(group->saved_size());
  }
}

void Summary::advance(double slice, std::int64_t bound, const std::stop_token& stop) {
  Parts& all = *parts_;
  if (!all.in_round) all.begin_round(slice, bound);
  const std::span groups(all.groups);
  const auto part = all.rounds.next(groups, all.round_steps(), slice);
  const auto states = std::span(all.states).subspan(all.first_state);
  const double share = static_cast<double>(part.size()) / static_cast<double>(groups.size());
  const double nanoseconds = share * all.step_cost * all.round_steps();
  for_each_in_parallel(part, nanoseconds, [&](const std::unique_ptr<MemberGroup>& group) {
    group->advance(all.round_end, all.first_time, states, stop);
  });
  all.interrupted =
      std::ranges::any_of(part, [](const auto& group) { return group->interrupted(); });
  if (all.interrupted) return;
  all.rounds.pass(part.size(), groups.size());
  if (all.rounds.aligned()) all.end_round();
}

void Summary::cancel() {
  for (const auto& group : parts_->groups) group->cancel();
  parts_->rounds.give_up();
  parts_->in_round = false;
}

std::int64_t Summary::step() const { return parts_->step; }
bool Summary::done() const { return parts_->done(); }
bool Summary::interrupted() const { return parts_->interrupted; }
bool Summary::aligned() const { return !parts_->in_round; }

std::vector<Event> Summary::take_events() { return std::exchange(parts_->events, {}); }
std::vector<StateAtTime> Summary::take_states() {
  if (parts_->in_round) return {};
  return std::exchange(parts_->states, {});
}

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
