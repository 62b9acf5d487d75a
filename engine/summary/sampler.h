#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/summary/joint_simulation.h"
#include "engine/summary/member.h"
#include "engine/summary/plan.h"

namespace stiefel {

/// Takes samples of the members of a group for their statistics. If only drifts are asked for that
/// can be read from saved states (Reading::largest_drift), the states of several samples are kept
/// and read together, so that their divisions overlap.
class Sampler {
 public:
  /// The plan must outlive the sampler.
  Sampler(const Plan& plan, std::span<const Member> members);

  /// Reads a sample of one member. A stop request may leave it incomplete.
  void take(Member& member, const Simulation& now, const std::stop_token& stop);
  /// Takes a sample of every member that has not ended; it may wait until `read_waiting`.
  void take_all(std::span<Member> members, const JointSimulation& motion,
                const std::stop_token& stop);
  void read_waiting(std::span<Member> members, const JointSimulation& motion);

  /// Takes the memory for samples that wait, at most for `samples`, or frees it.
  void make_room(std::int64_t samples, const JointSimulation& motion);
  void free_room() { saved_ = {}; }

 private:
  const Plan& plan_;
  std::vector<std::size_t> quantities_;  ///< indices of those that are read at every sample
  bool reads_saved_;                     ///< whether all of them can be read from saved states
  std::vector<double> values_, drifts_;
  std::vector<double> saved_;  ///< states of `waiting_` samples
  std::size_t waiting_ = 0;
};

}  // namespace stiefel
