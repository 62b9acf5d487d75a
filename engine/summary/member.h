#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/summary/accumulators.h"
#include "engine/summary/partial_step.h"
#include "engine/summary/plan.h"
#include "engine/summary/readings.h"

namespace stiefel {

/// How a member's motion ended.
struct MemberEnd {
  RunStatus status;
  std::int64_t last_step = 0;
  std::int64_t ended_by = -1;  ///< index of the terminal event that ended it, or −1
  double rate = 0;             ///< Simulation::rate at the last good state
};

/// What a summary keeps of one member: its statistics, its events and its end.
class Member {
 public:
  /// Takes member `index` of an ensemble, or a single scene. Scene, plan and `last` must outlive
  /// the member.
  Member(const Scene& all, std::size_t index, const Plan& plan, std::span<double> last);
  /// Makes readings of its own; `start` is its simulation at step 0. Without them
  /// Plan::Read::common reads its states.
  void make_readings(const Simulation& start, const Plan& plan);

  /// Its scene, and its states between steps, which are made when they are asked for.
  const Scene& scene();
  PartialStep& between();

  Reading& reading(const Plan& plan, std::size_t quantity) {
    return readings_.empty() ? *plan.reads[quantity].common : *readings_[quantity];
  }
  /// Sets `last` to the values of the quantities at the last good state, and the end.
  void finish(const Simulation& now, const MemberEnd& how, const Plan& plan,
              const std::stop_token& stop);
  /// Saves or restores everything but the state.
  void save(ByteWriter& out) const;
  void restore(ByteReader& in);

  std::size_t index;
  std::vector<Accumulators> accumulators;  ///< of each quantity; none if none reads on the way
  std::span<double> last;                  ///< the values of all quantities at the end
  std::vector<std::uint64_t> events;       ///< number so far, of each event of the description
  std::vector<double> g;                   ///< values of the events' functions at the current step
  std::optional<MemberEnd> end = {};

 private:
  void save_end(ByteWriter& out) const;
  void restore_end(ByteReader& in);

  const Scene* all_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<PartialStep> between_;
  std::vector<std::unique_ptr<Reading>> readings_;
};

/// The step that a member made last.
struct LastStep {
  std::int64_t to;                 ///< index of the state after it
  const Simulation& now;           ///< the state after it
  std::span<const double> before;  ///< the saved state before it; may be empty
};

}  // namespace stiefel
