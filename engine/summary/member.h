#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/summary/accumulators.h"
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

/// Computes states between the steps of one scene by the scene's own method: a shorter step from
/// the state before, or for a closed form the state at that time. It uses a simulation of its own.
class PartialStep {
 public:
  explicit PartialStep(const Scene& scene);

  /// Simulation::direct of the scene.
  bool direct() const { return direct_; }
  /// Returns a simulation in the state at step k + fraction, −1 < fraction < 2, valid until the
  /// next call; null where the shorter step has no solution, or on a stop request. `saved` is the
  /// state at step k; it is the result where the fraction is so small that no number would change.
  /// The step index of the returned simulation has no meaning.
  const Simulation* at(std::int64_t k, double fraction, std::span<const double> saved,
                       const std::stop_token& stop);
  /// Returns a simulation in the state at the first of several times, for a closed form only; valid
  /// until the next call. The next calls may ask for the other times.
  const Simulation* at_first_of(std::span<const double> times, const std::stop_token& stop);

 private:
  const Scene& scene_;
  std::unique_ptr<Simulation> simulation_;
  bool direct_;
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

/// Returns the values of the fields that are written at times and events (Plan::fields), one field
/// after another, at the state of `now`, the simulation of one member.
std::vector<double> written_fields(const Plan& plan, const Simulation& now);

/// Returns the arrays of Summary::statistics from all members, which have ended.
std::vector<SummaryArray> results(const Plan& plan, std::span<const Member* const> members,
                                  bool ensemble);

/// Returns how many bytes the numbers of these arrays take.
std::uint64_t result_bytes(const Plan& plan, std::size_t members);

}  // namespace stiefel
