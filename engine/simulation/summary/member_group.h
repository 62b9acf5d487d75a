#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/simulation/summary/accumulators.h"
#include "engine/simulation/summary/event_search.h"
#include "engine/simulation/summary/partial_step.h"
#include "engine/simulation/summary/plan.h"
#include "engine/simulation/summary/readings.h"

namespace stiefel {

/// How a member's motion ended.
struct MemberEnd {
  RunStatus status;
  std::int64_t last_step = 0;
  std::int64_t ended_by = -1;  ///< the terminal event
  double rate = 0;             ///< Simulation::rate at the last good state
};

/// Members of an ensemble that go together, as many as a vector register has lanes, or one scene
/// that is no ensemble. Those that have ended leave the group, and the others go on.
class MemberGroup {
 public:
  /// `first`: the index of the first member. Scenes and plan must outlive the group.
  MemberGroup(std::span<const Scene> scenes, std::size_t first, bool ensemble, const Plan& plan);

  /// With the states of its members at `step`, one after another.
  void start_at(std::int64_t step, std::span<const double> saved);
  std::size_t saved_size() const { return each_saved_ * scenes_.size(); }

  /// Goes on to step `to`. Writes its part of the states at times, of which the first is that of
  /// index `first_time`. Stopped on its way it is `interrupted`.
  void advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
               const std::stop_token& stop);
  bool interrupted() const { return interrupted_; }
  /// Ends the members that have not ended.
  void cancel();
  bool done() const { return alive_.empty(); }

  std::vector<Event>& events() { return events_; }
  /// The number of times up to the last one at which a member was there.
  std::size_t times_reached() const { return times_reached_; }
  std::int64_t computed_steps() const { return computed_; }

  std::size_t size() const { return scenes_.size(); }
  const MemberEnd& end(std::size_t member) const { return *members_[member].end; }
  const Accumulators& accumulators(std::size_t member, std::size_t quantity) const {
    return members_[member].accumulators[quantity];
  }
  /// The values of a quantity at the last sample.
  const std::vector<double>& last(std::size_t member, std::size_t quantity) const {
    return members_[member].last[quantity];
  }

  /// Whether the first sample has been taken.
  bool begun() const { return begun_; }
  /// The members, one after another, however they are grouped.
  void save(ByteWriter& out) const;
  void restore(std::int64_t step, bool begun, ByteReader& in);

 private:
  struct Member {
    const Scene* scene;
    std::vector<std::unique_ptr<Reading>> readings;
    std::vector<Accumulators> accumulators;
    std::vector<std::vector<double>> last;
    std::vector<std::uint64_t> events;  ///< how many of each there were
    std::vector<double> g;              ///< at the present step
    PartialStep between;
    std::optional<MemberEnd> end = {};
  };
  /// A zero after the state of step_ − 1.
  struct Found {
    std::size_t event;
    double fraction;
  };

  /// The state of the i-th member that goes on.
  const Simulation& state(std::size_t i) const;
  std::span<const double> state_before(std::size_t i) const;
  Member& going(std::size_t i) { return members_[alive_[i]]; }

  /// The next step at which something is to be done, at most `to`.
  std::int64_t next_stop(std::int64_t to) const;
  bool go(std::int64_t next, const std::stop_token& stop);
  /// From sample to sample, as long as nothing else is to be done, up to `to`. False when it was
  /// asked to stop.
  bool go_by_samples(std::int64_t to, const std::stop_token& stop);
  /// A sample of every member that goes on; where its state suffices it may wait.
  void take_samples();
  void make_room(std::int64_t samples);
  void take_saved();
  void arrive(std::size_t first_time, std::span<StateAtTime> states);
  void begin(std::size_t first_time, std::span<StateAtTime> states);
  void take_sample(Member& member, const Simulation& now);
  bool waits_for_events() const;
  /// The zeros of a member in the step that was made, in their order.
  std::vector<Found> find_events(std::size_t i);
  /// Reports them; the fraction after which the member ends, if it does.
  std::optional<double> report_events(std::size_t i);
  void write_states(std::size_t i, double up_to, std::size_t first_time,
                    std::span<StateAtTime> states);
  std::vector<double> written(const Simulation& now) const;
  void finish(std::size_t i, const Simulation& last, std::int64_t step, RunStatus status,
              std::int64_t ended_by = -1);
  /// Takes the members out that have ended.
  void regroup();
  /// From now on the simulation is that of these scenes; none where there are none.
  void keep(std::vector<Scene> remaining);
  static void save_end(const Member& member, ByteWriter& out);
  void restore_end(Member& member, ByteReader& in);
  void resume(std::int64_t step, bool begun, std::span<const double> saved);

  std::span<const Scene> scenes_;
  std::size_t first_;
  bool ensemble_;
  const Plan& plan_;
  std::vector<Member> members_;
  std::vector<std::size_t> alive_;            ///< in members_
  std::vector<std::size_t> read_on_the_way_;  ///< quantities that are read at every sample
  bool reads_saved_ = false;                  ///< all of them by Reading::largest_drift
  std::vector<Scene> remaining_;              ///< their scenes, once some have left
  std::unique_ptr<Simulation> simulation_;
  bool direct_;
  std::size_t each_saved_;
  EventFunctions functions_;
  std::vector<double> before_;  ///< the states at step_ − 1, where they are needed
  std::vector<double> saved_;   ///< the states of `waiting_` samples, read together
  std::size_t waiting_ = 0;
  std::vector<double> values_, drifts_, g_;
  std::vector<Event> events_;
  std::int64_t step_ = 0, next_sample_ = 0, computed_ = 0;
  std::size_t next_time_ = 0, times_reached_ = 0;
  std::stop_token stop_;
  bool begun_ = false, interrupted_ = false;
};

}  // namespace stiefel
