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

/// The groups of a scene's members, which advance in rounds.
class SummaryOfGroups final : public Summary {
 public:
  SummaryOfGroups(const Scene& scene, Plan plan, std::unique_ptr<Simulation> start,
                  const std::shared_ptr<const FlatBodies>& flat)
      : scene_(scene), plan_(std::move(plan)), direct_(start->direct()) {
    if (scene.members().empty()) {
      step_cost_ = start->step_cost();
      JointMotion motion(scene, nullptr, 0, 1, std::move(start));
      groups_.push_back(std::make_unique<MemberGroup>(scene, std::move(motion), plan_));
      return;
    }
    members_ = scene.members().size();
    const Scene first = scene.members().front();
    const std::size_t size = group_size(first, flat.get());
    groups_.resize((members_ + size - 1) / size);
    const double nanoseconds = static_cast<double>(members_) * (flat ? of_body : of_member);
    for_each_in_parallel(std::span(groups_), nanoseconds, [&](auto& group) {
      const std::size_t from = size * static_cast<std::size_t>(&group - groups_.data());
      JointMotion motion(scene, flat, from, std::min(size, members_ - from));
      group = std::make_unique<MemberGroup>(scene, std::move(motion), plan_);
    });
    std::size_t packed = 0;
    for (const auto& group : groups_) packed += group->packed();
    step_cost_ = stiefel::step_cost(first, *start, members_, packed);
  }

  void start_at(std::int64_t step, std::span<const double> saved) override {
    step_ = step;
    for (const auto& group : groups_) {
      group->start_at(step, saved.first(group->saved_size()));
      saved = saved.subspan(group->saved_size());
    }
  }

  void advance(double slice, std::int64_t bound, const std::stop_token& stop) override {
    if (!in_round_) begin_round(slice, bound);
    const std::span groups(groups_);
    const auto part = rounds_.next(groups, round_steps(), slice);
    const auto states = std::span(states_).subspan(first_state_);
    const double share = static_cast<double>(part.size()) / static_cast<double>(groups.size());
    const double nanoseconds = share * step_cost_ * round_steps();
    for_each_in_parallel(part, nanoseconds, [&](const std::unique_ptr<MemberGroup>& group) {
      group->advance(round_end_, first_time_, states, stop);
    });
    interrupted_ =
        std::ranges::any_of(part, [](const auto& group) { return group->interrupted(); });
    if (interrupted_) return;
    rounds_.pass(part.size(), groups.size());
    if (rounds_.aligned()) end_round();
  }

  void cancel() override {
    for (const auto& group : groups_) group->cancel();
    rounds_.give_up();
    in_round_ = false;
  }

  std::int64_t step() const override { return step_; }
  bool done() const override { return !in_round_ && going() == nullptr; }
  bool interrupted() const override { return interrupted_; }
  bool aligned() const override { return !in_round_; }

  std::vector<Event> take_events() override { return std::exchange(events_, {}); }
  std::vector<StateAtTime> take_states() override {
    return in_round_ ? std::vector<StateAtTime>() : std::exchange(states_, {});
  }

  RunStatus status() const override {
    const Member* first = first_stop();
    if (first == nullptr) return {};
    RunStatus status = first->end->status;
    if (!scene_.members().empty()) status.member = static_cast<std::int64_t>(first->index);
    return status;
  }
  double rate() const override {
    const Member* first = first_stop();
    return first == nullptr ? 0 : first->end->rate;
  }

  std::vector<SummaryArray> statistics() const override {
    return results(plan_, members(), !scene_.members().empty());
  }
  std::uint64_t statistics_bytes() const override { return result_bytes(plan_, members_); }

  std::string save() const override {
    ByteWriter out;
    out.put(step_);
    out.put(computed_steps());
    out.put(going() != nullptr && going()->begun());
    for (const auto& group : groups_) group->save(out);
    return out.take();
  }

  bool restore(std::string_view saved) override {
    ByteReader in(saved);
    bool begun = false;
    std::int64_t step = 0, computed = 0;
    in.get(step);
    in.get(computed);
    in.get(begun);
    if (!in.sound() || step < 0 || step > plan_.what.to) return false;
    for (const auto& group : groups_) group->restore(step, begun, in);
    const bool outside = begun ? step < plan_.what.from : step > plan_.what.from;
    if (!in.complete() || (outside && !done())) return false;
    step_ = step;
    computed_before_ = computed;
    while (begun && next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= step)
      ++next_time_;
    return true;
  }

  std::int64_t computed_steps() const override {
    std::int64_t sum = computed_before_;
    for (const auto& group : groups_) sum += group->computed_steps();
    return sum;
  }
  std::int64_t map_steps() const override {
    std::int64_t sum = 0;
    for (const auto& group : groups_) sum += group->map_steps();
    return sum;
  }
  bool reads_on_the_way() const override {
    return plan_.reads_on_the_way || !plan_.what.events.empty();
  }
  const SummaryDescription& description() const override { return plan_.what; }

 private:
  /// Returns how many members a group has: as many packs as leave enough groups to divide.
  std::size_t group_size(const Scene& first, const FlatBodies* flat) const {
    constexpr std::size_t least_groups = 64, most_packs = 16;
    if (!flat) return can_be_packed(first) ? static_cast<std::size_t>(body_lanes(first)) : 1;
    const auto lanes = static_cast<std::size_t>(flat->lanes());
    return lanes * std::clamp(members_ / (lanes * least_groups), std::size_t{1}, most_packs);
  }

  /// Returns a group that is not done, or null.
  const MemberGroup* going() const {
    for (const auto& group : groups_)
      if (!group->done()) return group.get();
    return nullptr;
  }

  std::vector<const Member*> members() const {
    std::vector<const Member*> all;
    for (const auto& group : groups_)
      for (const Member& member : group->members()) all.push_back(&member);
    return all;
  }
  /// Returns the member that stopped first, or null.
  const Member* first_stop() const {
    const Member* first = nullptr;
    for (const Member* member : members())
      if (!member->end->status.reached() &&
          (!first || member->end->last_step < first->end->last_step))
        first = member;
    return first;
  }

  /// Returns how many steps of a closed form are computed as one.
  std::int64_t jump() const {
    const std::int64_t jump = plan_.reads_on_the_way ? plan_.what.every : plan_.what.to - step_;
    return direct_ && plan_.what.events.empty() ? std::max<std::int64_t>(jump, 1) : 1;
  }

  /// Returns the step at which a round ends that begins with a slice of so many steps.
  std::int64_t target(double slice, std::int64_t bound) const {
    const SummaryDescription& what = plan_.what;
    bound = std::min(bound, what.to);
    double steps = Rounds::steps(groups_.size(), slice);
    if (!what.events.empty()) {
      const std::size_t each = members_ * what.events.size() * (plan_.state_size + 8);
      steps = std::min(steps, static_cast<double>(most_waiting / each + 1));
    }
    steps = std::floor(steps) * static_cast<double>(jump());
    std::int64_t to = steps < static_cast<double>(bound - step_)
                          ? step_ + static_cast<std::int64_t>(steps)
                          : bound;
    const std::size_t most = most_waiting / std::max<std::size_t>(1, members_ * plan_.state_size);
    if (plan_.times.size() - next_time_ > most)
      to = std::min(to, std::max(plan_.times[next_time_ + most].arrival - 1,
                                 plan_.times[next_time_].arrival));
    return std::max(to, step_);
  }

  /// Returns the steps of the round, those of a jump as one.
  double round_steps() const {
    return std::ceil(static_cast<double>(round_end_ - step_) / static_cast<double>(jump()));
  }

  /// Begins a round with a slice of so many steps, and appends empty states for its times.
  void begin_round(double slice, std::int64_t bound) {
    in_round_ = true;
    round_end_ = target(slice, bound);
    first_time_ = next_time_;
    first_state_ = states_.size();
    const auto& times = plan_.times;
    for (; next_time_ < times.size() && times[next_time_].arrival <= round_end_; ++next_time_)
      states_.push_back({times[next_time_].before, plan_.what.times[next_time_],
                         std::vector<double>(members_ * plan_.state_size, canonical(NAN))});
  }

  void end_round() {
    in_round_ = false;
    step_ = round_end_;
    const auto before = static_cast<std::ptrdiff_t>(events_.size());
    for (const auto& group : groups_) {
      std::ranges::move(group->events(), std::back_inserter(events_));
      group->events().clear();
    }
    std::ranges::stable_sort(events_.begin() + before, events_.end(), {}, [](const Event& e) {
      return std::tuple(e.step, e.member, e.fraction, e.event);
    });
    if (!done()) return;
    // Removes the states at times that no member reached.
    std::size_t reached = first_time_;
    for (const auto& group : groups_) reached = std::max(reached, group->times_reached());
    states_.resize(states_.size() - (next_time_ - reached));
  }

  const Scene& scene_;
  const Plan plan_;
  std::vector<std::unique_ptr<MemberGroup>> groups_;
  std::size_t members_ = 1;
  bool direct_;
  double step_cost_ = 0;  ///< nanoseconds for a step of all members, without the reading
  std::int64_t step_ = 0, computed_before_ = 0;
  Rounds rounds_;
  bool in_round_ = false;  ///< whether some groups are to advance to `round_end_`
  std::int64_t round_end_ =
      0;  ///< step to which the groups advance, one part of them after another
  std::size_t next_time_ = 0, first_time_ = 0, first_state_ = 0;  ///< the first ones of the round
  bool interrupted_ = false;
  std::vector<Event> events_;
  std::vector<StateAtTime> states_;
};

}  // namespace

std::expected<std::unique_ptr<Summary>, Violations> Summary::prepare(const Scene& scene,
                                                                     SummaryDescription what,
                                                                     const Simulation* begun) {
  const auto members = scene.members();
  const auto* ensemble = dynamic_cast<const Ensemble*>(begun);
  const auto flat = ensemble ? ensemble->flat() : flat_bodies(scene);
  auto start = members.empty() ? make_simulation(scene) : make_simulation(members.front());
  auto plan = make_plan(scene, *start, std::move(what));
  if (!plan) return std::unexpected(std::move(plan.error()));
  return std::make_unique<SummaryOfGroups>(scene, *std::move(plan), std::move(start), flat);
}

}  // namespace stiefel
