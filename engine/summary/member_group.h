#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/motion/joint_motion.h"
#include "engine/summary/events.h"
#include "engine/summary/member.h"
#include "engine/summary/plan.h"

namespace stiefel {

/// Consecutive members of an ensemble, or one scene that is no ensemble. Members that have ended
/// leave the group, and the others go on.
class MemberGroup {
 public:
  /// Takes members of the scene in their motion. Scene and plan must outlive the group.
  MemberGroup(const Scene& scene, JointMotion motion, const Plan& plan);

  /// Starts from the states of its members at `step`, one after another.
  void start_at(std::int64_t step, std::span<const double> saved);
  std::size_t saved_size() const { return motion_.each_saved() * members_.size(); }
  /// Returns how many of the members advance with others in vector registers.
  std::size_t packed() const { return motion_.packed(); }

  /// Advances to step `to`. Writes its part of `states`, the states at times, of which the first
  /// belongs to time index `first_time`. A stop request on the way makes it `interrupted`.
  void advance(std::int64_t to, std::size_t first_time, std::span<StateAtTime> states,
               const std::stop_token& stop);
  bool interrupted() const { return interrupted_; }
  /// Ends the members that have not ended.
  void cancel();
  bool done() const { return motion_.size() == 0; }

  std::vector<Event>& events() { return events_.reported(); }
  /// Returns the number of times up to the last one that any member reached.
  std::size_t times_reached() const { return times_reached_; }
  std::int64_t computed_steps() const { return computed_; }
  std::int64_t map_steps() const { return motion_.map_steps(); }

  std::span<const Member> members() const { return members_; }

  /// Whether the first sample has been taken.
  bool begun() const { return begun_; }
  /// Saves or restores the members one after another; the bytes do not depend on how members are
  /// grouped.
  void save(ByteWriter& out) const;
  void restore(std::int64_t step, bool begun, ByteReader& in);

 private:
  /// Returns the number of members that have not ended; i below counts these.
  std::size_t left() const { return motion_.size(); }
  Member& member(std::size_t i) { return members_[motion_.index(i) - first_]; }
  LastStep last_step(std::size_t i) const;

  bool waits_for_events() const;
  /// Returns the next step at which something is to be done, at most `to`.
  std::int64_t next_stop(std::int64_t to) const;
  /// Advances to step `next`. Returns false on a stop request, which may leave members at other
  /// steps.
  bool go(std::int64_t next, const std::stop_token& stop);
  bool go(JointMotion::Group& group, std::int64_t next, const std::stop_token& stop);
  /// Keeps the states at this step if the next one has times or events between its states.
  void keep_states_before();
  /// Does what is to be done at the first sample, or after a step.
  void begin();
  void arrive();
  /// Returns the first time beyond the current step, or null.
  const Plan::Time* next_time() const {
    return next_time_ < plan_.times.size() ? &plan_.times[next_time_] : nullptr;
  }
  /// Passes over the times up to step `to`.
  void pass_times(std::int64_t to) {
    while (next_time_ < plan_.times.size() && plan_.times[next_time_].arrival <= to) ++next_time_;
  }
  /// Writes the states of a member at the times up to the fraction `up_to` of its last step.
  void write_states(Member& member, const LastStep& step, double up_to);
  /// Takes a sample of a member for its statistics. A stop request may leave it incomplete.
  void sample(Member& member, const Simulation& now);
  /// Reports the events of a member in its last step. Returns the fraction of the step after which
  /// the member ends, if it ends.
  std::optional<double> report_events(std::size_t i);
  void finish(std::size_t i, const Simulation& last, std::int64_t step, const RunStatus& status,
              std::int64_t ended_by = -1);
  /// Removes the members that have ended.
  void regroup();

  std::size_t first_;
  const Plan& plan_;
  JointMotion motion_;
  bool direct_;
  Events events_;
  std::vector<double> lasts_;  ///< Member::last of all
  std::vector<Member> members_;
  std::vector<double> before_;           ///< states at the step before, where they are needed
  std::vector<double> values_, drifts_;  ///< of one quantity at a sample
  std::int64_t step_ = 0;                ///< of all members
  std::int64_t computed_ = 0, next_sample_ = 0;
  std::size_t next_time_ = 0, times_reached_ = 0;
  std::size_t first_time_ = 0;  ///< time index of the first of `states_`
  std::span<StateAtTime> states_;
  std::stop_token stop_;
  bool begun_ = false, interrupted_ = false;
};

}  // namespace stiefel
