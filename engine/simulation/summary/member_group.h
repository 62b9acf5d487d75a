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
  std::int64_t ended_by = -1;  ///< index of the terminal event that ended it, or −1
  double rate = 0;             ///< Simulation::rate at the last good state
};

/// Members of an ensemble that advance together, as many as a vector register has lanes, or one
/// scene that is no ensemble. Members that have ended leave the group, and the others go on.
class MemberGroup {
 public:
  /// `first` is the index of the first member. Scenes and plan must outlive the group.
  MemberGroup(std::span<const Scene> scenes, std::size_t first, bool ensemble, const Plan& plan);

  /// Starts from the states of its members at `step`, one after another.
  void start_at(std::int64_t step, std::span<const double> saved);
  std::size_t saved_size() const { return each_saved_ * scenes_.size(); }

  /// Advances to step `to`. Writes its part of `states`, the states at times, of which the first
  /// belongs to time index `first_time`. A stop request on the way makes it `interrupted`.
  void advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
               const std::stop_token& stop);
  bool interrupted() const { return interrupted_; }
  /// Ends the members that have not ended.
  void cancel();
  bool done() const { return alive_.empty(); }

  std::vector<Event>& events() { return events_; }
  /// Returns the number of times up to the last one that any member reached.
  std::size_t times_reached() const { return times_reached_; }
  std::int64_t computed_steps() const { return computed_; }

  std::size_t size() const { return scenes_.size(); }
  const MemberEnd& end(std::size_t member) const { return *members_[member].end; }
  const Accumulators& accumulators(std::size_t member, std::size_t quantity) const {
    return members_[member].accumulators[quantity];
  }
  /// Returns the values of a quantity at the last sample.
  const std::vector<double>& last(std::size_t member, std::size_t quantity) const {
    return members_[member].last[quantity];
  }

  /// Whether the first sample has been taken.
  bool begun() const { return begun_; }
  /// Saves or restores the members one after another; the bytes do not depend on how members are
  /// grouped.
  void save(ByteWriter& out) const;
  void restore(std::int64_t step, bool begun, ByteReader& in);

 private:
  struct Member {
    const Scene* scene;
    std::vector<std::unique_ptr<Reading>> readings;
    std::vector<Accumulators> accumulators;
    std::vector<std::vector<double>> last;
    /// Number of events so far, for each event of the description.
    std::vector<std::uint64_t> events;
    std::vector<double> g;  ///< values of g at the current step
    PartialStep between;
    std::optional<MemberEnd> end = {};
  };
  /// A zero of an event's function in the step from step_ − 1 to step_.
  struct Found {
    std::size_t event;
    double fraction;
  };

  /// Returns the state of the i-th member that has not ended.
  const Simulation& state(std::size_t i) const;
  std::span<const double> state_before(std::size_t i) const;
  Member& going(std::size_t i) { return members_[alive_[i]]; }

  /// Returns the next step at which something is to be done, at most `to`.
  std::int64_t next_stop(std::int64_t to) const;
  bool go(std::int64_t next, const std::stop_token& stop);
  /// Advances from sample to sample up to `to`, as long as nothing else is to be done. Returns
  /// false on a stop request.
  bool go_by_samples(std::int64_t to, const std::stop_token& stop);
  /// Takes a sample of every member that has not ended. If quantities can be read from saved
  /// states, the states are kept and read later together.
  void take_samples();
  void make_room(std::int64_t samples);
  void take_saved();
  void arrive(std::size_t first_time, std::span<StateAtTime> states);
  void begin(std::size_t first_time, std::span<StateAtTime> states);
  void take_sample(Member& member, const Simulation& now);
  bool waits_for_events() const;
  /// Returns the zeros of a member's events in the last step, in their order.
  std::vector<Found> find_events(std::size_t i);
  /// Reports the events of a member in the last step. Returns the fraction of the step after which
  /// the member ends, if it ends.
  std::optional<double> report_events(std::size_t i);
  void write_states(std::size_t i, double up_to, std::size_t first_time,
                    std::span<StateAtTime> states);
  std::vector<double> written(const Simulation& now) const;
  void finish(std::size_t i, const Simulation& last, std::int64_t step, RunStatus status,
              std::int64_t ended_by = -1);
  /// Removes the members that have ended.
  void regroup();
  /// Replaces the simulation by one of the remaining scenes, or by none if there are none.
  void keep(std::vector<Scene> remaining);
  static void save_end(const Member& member, ByteWriter& out);
  void restore_end(Member& member, ByteReader& in);
  void resume(std::int64_t step, bool begun, std::span<const double> saved);

  std::span<const Scene> scenes_;
  std::size_t first_;
  bool ensemble_;
  const Plan& plan_;
  std::vector<Member> members_;
  std::vector<std::size_t> alive_;  ///< indices in members_ of those that have not ended
  /// Indices of quantities that are read at every sample.
  std::vector<std::size_t> read_on_the_way_;
  bool reads_saved_ = false;      ///< whether all of them are read by Reading::largest_drift
  std::vector<Scene> remaining_;  ///< scenes of the members in alive_, once a member has left
  std::unique_ptr<Simulation> simulation_;
  bool direct_;
  std::size_t each_saved_;
  EventFunctions functions_;
  std::vector<double> before_;  ///< states at step_ − 1, where they are needed
  std::vector<double> saved_;   ///< states of `waiting_` samples, to be read together
  std::size_t waiting_ = 0;
  std::vector<double> values_, drifts_, g_;
  std::vector<Event> events_;
  std::int64_t step_ = 0, next_sample_ = 0, computed_ = 0;
  std::size_t next_time_ = 0, times_reached_ = 0;
  std::stop_token stop_;
  bool begun_ = false, interrupted_ = false;
};

}  // namespace stiefel
