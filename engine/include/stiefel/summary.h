#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "stiefel/run_status.h"
#include "stiefel/scene.h"
#include "stiefel/violation.h"

namespace stiefel {

/// A number made of the values of a quantity at the samples, for each of its elements.
enum class Statistic {
  last,          ///< at the last sample
  min,           ///< the least
  max,           ///< the largest
  mean,          ///< their sum, compensated, divided by their number
  rms,           ///< root of the mean of the squares
  sign_changes,  ///< from one sample to the next; a 0 continues the sign before it
  drift,  ///< of an invariant its largest drift (diagnosis.h); of a field max |value − at step 0|
};

/// The statistics asked of a field, an invariant ("energy", "spatial_momentum[1,2]") or a family of
/// invariants ("spatial_momentum"). A complex field has `last` and `mean`.
struct Quantity {
  std::string name;
  std::vector<Statistic> statistics;
  std::vector<double> quantiles =
      {};                          ///< fractions in [0, 1]; linear between two neighbours in order
  std::vector<double> edges = {};  ///< increasing: counts in [e_0, e_1), …, [e_{last−1}, e_last]
  bool over_members = false;       ///< of an ensemble: of the values of all members
};

enum class Direction { both, rising, falling };

/// Zeros of g = Σ coefficients_i · field_i − level. There is one after state k where g_k < 0 ≤
/// g_{k+1} (rising) or g_k > 0 ≥ g_{k+1} (falling): two zeros between the same two states are not
/// seen.
struct EventDescription {
  std::string field;
  std::vector<double> coefficients = {};  ///< one for each number of the field, row by row
  double level = 0;
  Direction direction = Direction::both;
  std::uint64_t limit = 0;  ///< only the first so many, of each member; 0: all
  bool terminal = false;    ///< ends the motion at the last one of `limit`, the first if that is 0
};

/// What Summary computes. Samples are at from, from + every, … and always at `to`, or where the
/// motion ends before.
struct SummaryDescription {
  std::int64_t from = 0, to = 0, every = 1;
  std::vector<Quantity> quantities = {};
  std::vector<EventDescription> events = {};  ///< after `from`, up to `to`
  std::vector<double> times = {};  ///< in the order of the motion, from time(from) to time(to)
  std::vector<std::string> fields = {};  ///< written at events and times; the blocks when empty
};

/// The number of a statistic for every element, row-major; before the elements' axes the members'.
struct SummaryArray {
  enum class Type { real, complex, count };
  std::string name;  ///< "energy.drift", "M.quantiles"
  std::vector<std::size_t> shape;
  Type type = Type::real;
  std::vector<double> numbers;       ///< of a complex array pairs
  std::vector<std::int64_t> counts;  ///< instead of numbers
};

/// An event. `fields` has the numbers of SummaryDescription::fields, one after another.
struct Event {
  std::size_t event;  ///< index in SummaryDescription::events
  std::int64_t step;  ///< the last one before it
  double fraction;    ///< it is at step + fraction, 0 < fraction ≤ 1; of a discrete system 1
  double time;
  std::size_t member;
  std::vector<double> fields;
};

/// A state at a time of the description, up to the last one at which a member was there. `fields`:
/// field after field, in each member after member; NaN for members that ended before.
struct StateAtTime {
  std::int64_t step;  ///< the last one at or before it
  double time;
  std::vector<double> fields;
};

/// Statistics, events and states at any times, computed beside the steps. The result depends on
/// scene and description alone: neither on threads, nor on how the steps were divided into calls,
/// nor on a `save` and `restore` on the way. The members of an ensemble go independently: each has
/// the bits that it has alone, and the others go on without one that ends. Not thread-safe.
///
/// A state between two steps is what the method makes of the state before with a shorter step, of a
/// closed form the state at that time; the sequence of states does not change.
class Summary {
 public:
  static constexpr std::size_t max_quantities = 64, max_events = 64;
  static constexpr std::size_t max_times = std::size_t{1} << 20;
  /// Values that quantiles keep: of all quantities, elements, members and samples.
  static constexpr std::uint64_t max_kept = std::uint64_t{1} << 20;
  /// Numbers that accumulators and results hold.
  static constexpr std::uint64_t max_numbers = std::uint64_t{1} << 24;

  /// At step 0. The violations are of the fields of SummaryRequest: "quantities[0].name".
  static std::expected<Summary, Violations> prepare(const Scene& scene, SummaryDescription what);
  Summary(Summary&&) noexcept;
  ~Summary();

  /// Begins with a state that `Simulation::save` gave at `step` ≤ from.
  void start_at(std::int64_t step, std::span<const double> saved);
  /// Goes on by up to `steps` steps of all members, not beyond `bound`. Returns earlier when many
  /// events or states wait to be taken. Looks at `stop` before every step.
  ///
  /// Of many members with neither events nor times a call takes a part of the members by as many
  /// more steps, and the next calls take the others to where the first went, whatever their `steps`
  /// and `bound`. Each member is then fetched from memory once for all of these steps.
  void advance(std::int64_t steps, std::int64_t bound, const std::stop_token& stop = {});
  /// Ends where it is: with `cancelled` for all that have not ended.
  void cancel();

  /// All is done up to this step.
  std::int64_t step() const;
  bool done() const;
  /// Whether the last `advance` was stopped on its way.
  bool interrupted() const;
  /// Whether all members that have not ended are at `step()`.
  bool aligned() const;

  /// What has come since the last call, in the order of steps, at one step of members, then times.
  std::vector<Event> take_events();
  std::vector<StateAtTime> take_states();

  /// Once it is done. In an ensemble the status of the member that stopped first.
  RunStatus status() const;
  /// Simulation::rate at the last good state of that member.
  double rate() const;
  /// Once it is done: the statistics in the order of the quantities, then "outcome", "last_step",
  /// "ended_by" and "samples".
  std::vector<SummaryArray> statistics() const;
  /// Bytes of the numbers of `statistics`.
  std::uint64_t statistics_bytes() const;

  /// Everything that decides what is still to come; only when it is `aligned`. `restore` returns
  /// false for what `save` of the same scene and description, but for `to`, cannot have given.
  std::string save() const;
  bool restore(std::string_view saved);

  /// Steps of all members so far.
  std::int64_t computed_steps() const;
  /// Whether samples are read at every step of the grid, and events looked for: work that
  /// step_weight does not count.
  bool reads_on_the_way() const;

  const SummaryDescription& description() const;

 private:
  struct Parts;
  explicit Summary(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace stiefel
