#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "stiefel/run_status.h"
#include "stiefel/simulation.h"
#include "stiefel/violation.h"

namespace stiefel {

/// A statistic of a quantity over the samples, computed for each of its elements.
enum class Statistic {
  last,  ///< the value at the last sample
  min,
  max,
  mean,  ///< compensated sum of the values, divided by their number
  rms,   ///< square root of the mean of the squares
  /// Number of changes from one sample to the next; a 0 has the sign of the sample before it.
  sign_changes,
  /// Of an invariant: its largest drift (diagnosis.h); of a field: max |value − value at step 0|.
  drift,
};

/// The statistics asked of a field, of an invariant ("energy", "spatial_momentum[0,1]") or of a
/// family of invariants ("spatial_momentum"). A complex field offers `last` and `mean` only.
struct Quantity {
  std::string name;
  std::vector<Statistic> statistics;
  /// Fractions in [0, 1]; interpolated linearly between neighbours in sorted order.
  std::vector<double> quantiles = {};
  /// Increasing edges of a histogram: counts in [e_0, e_1), …, [e_{last−1}, e_last].
  std::vector<double> edges = {};
  bool over_members = false;  ///< of an ensemble: one statistic over the values of all members
};

enum class Direction { both, rising, falling };

/// Σ coefficients_i · field_i.
struct LinearTerm {
  std::string field;
  std::vector<double> coefficients = {};  ///< one for each number of the field, row by row
};

/// An event: a zero of g = Σ coefficients_i · field_i − level + Σ plus. There is one after state k
/// where g_k < 0 ≤ g_{k+1} (rising) or g_k > 0 ≥ g_{k+1} (falling). Two zeros between the same two
/// states go unnoticed. With Euler angles, g is taken modulo its jump, and where it changes by half
/// of it or more from one state to the next there is no event.
///
/// The event of an extremum is a zero of g' in place of g: rising at a minimum, falling at a
/// maximum. g' at a state is the central difference of sixth order of g at the states ±3, ±6 and
/// ±9 % of a step away, each computed by one step of the method from that state, so that its error
/// is that of the differences alone. The time is accurate to about 1e-14 |g|/(h²|g''|) steps by
/// rounding, and to 1e-11 (h rate)⁵ steps.
struct EventDescription {
  std::string field;
  std::vector<double> coefficients = {};  ///< one for each number of the field, row by row
  double level = 0;
  Direction direction = Direction::both;
  std::uint64_t limit = 0;  ///< reports only the first `limit` events of each member; 0: all
  /// Ends the motion at event number `limit`, or at the first if `limit` is 0.
  bool terminal = false;
  std::vector<LinearTerm> plus = {};  ///< of more fields
  bool extremum = false;
};

/// What a Summary computes. Samples are at from, from + every, … and always at `to`, or at the last
/// state if the motion ends before.
struct SummaryDescription {
  std::int64_t from = 0, to = 0, every = 1;
  std::vector<Quantity> quantities = {};
  std::vector<EventDescription> events = {};  ///< looked for after `from`, up to `to`
  std::vector<double> times = {};  ///< in the order of the motion, between time(from) and time(to)
  /// Fields reported at events and times; the blocks when empty.
  std::vector<std::string> fields = {};
};

/// One statistic of a quantity for every element, row-major; in an ensemble the axis of the members
/// comes first.
struct SummaryArray {
  enum class Type { real, complex, count };
  std::string name;  ///< "energy.drift", "M.quantiles"
  std::vector<std::size_t> shape;
  Type type = Type::real;
  std::vector<double> numbers;       ///< in a complex array two numbers for each element
  std::vector<std::int64_t> counts;  ///< used in place of `numbers` for Type::count
};

/// An event that was found. `fields` holds the numbers of SummaryDescription::fields, one field
/// after another.
struct Event {
  std::size_t event;  ///< index in SummaryDescription::events
  std::int64_t step;  ///< last step before the event
  /// The event is at step + fraction, 0 < fraction ≤ 1; in a discrete system the fraction is 1.
  double fraction;
  double time;
  std::size_t member;
  std::vector<double> fields;
};

/// The state at one of the description's times, up to the last time that any member reached.
/// `fields` holds field after field, in each field member after member; NaN for members that ended
/// before.
struct StateAtTime {
  std::int64_t step;  ///< last step at or before the time
  double time;
  std::vector<double> fields;
};

/// Computes statistics, events and states at any times beside the steps. The result depends on
/// scene and description alone: not on the number of threads, on how the steps were divided into
/// calls, or on a `save` and `restore` on the way. The members of an ensemble are independent: each
/// has the bits that it has alone, and when one ends the others go on. Not thread-safe.
///
/// A state between two steps is what the method computes from the state before with a shorter step,
/// or the state at that time where there is a closed form. It does not change the sequence of
/// states.
class Summary {
 public:
  static constexpr std::size_t max_quantities = 64, max_events = 64;
  static constexpr std::size_t max_times = std::size_t{1} << 20;
  /// Most values kept for quantiles, over all quantities, elements, members and samples.
  static constexpr std::uint64_t max_kept = std::uint64_t{1} << 20;
  /// Most numbers in accumulators and results.
  static constexpr std::uint64_t max_numbers = std::uint64_t{1} << 24;

  /// Returns a summary at step 0, which refers to the scene: the scene must outlive it. The
  /// violations name the fields of the description, "quantities[0].name". What `begun`, a
  /// simulation of the scene, holds of an ensemble's members is not computed again; it need not
  /// outlive the call.
  static std::expected<std::unique_ptr<Summary>, Violations> prepare(
      const Scene& scene, SummaryDescription what, const Simulation* begun = nullptr);
  virtual ~Summary() = default;

  /// Starts from a state that `Simulation::save` wrote at `step` ≤ from, in place of step 0.
  virtual void start_at(std::int64_t step, std::span<const double> saved) = 0;
  /// Advances by a slice: the work, on each thread, of `slice` steps of all members (but at least
  /// one step of one), not beyond the step `bound`. Returns earlier when many events or states wait
  /// to be taken. Checks `stop` before every step.
  ///
  /// With many members one call advances only a part of the members, by many more steps; the next
  /// calls bring the other members to the same step, whatever their `bound`. This way a member is
  /// fetched from memory once for all of these steps.
  virtual void advance(double slice, std::int64_t bound, const std::stop_token& stop = {}) = 0;
  /// Ends the summary at its current step; members that have not ended get `cancelled`.
  virtual void cancel() = 0;

  /// The step up to which all is done.
  virtual std::int64_t step() const = 0;
  virtual bool done() const = 0;
  /// Whether the last `advance` was stopped on its way.
  virtual bool interrupted() const = 0;
  /// Whether all members that have not ended are at step `step()`.
  virtual bool aligned() const = 0;

  /// Return the events and the states found since the last call, once all members have passed them:
  /// events by step, then member, then time; states by time.
  virtual std::vector<Event> take_events() = 0;
  virtual std::vector<StateAtTime> take_states() = 0;

  /// Returns how the motion ended; valid once `done()`. For an ensemble the status of the member
  /// that stopped first.
  virtual RunStatus status() const = 0;
  /// Returns Simulation::rate at the last good state of the member of `status()`.
  virtual double rate() const = 0;
  /// Returns the statistics, valid once `done()`: in the order of the quantities, then "outcome",
  /// "last_step", "ended_by" and "samples".
  virtual std::vector<SummaryArray> statistics() const = 0;
  /// Returns how many bytes the numbers of `statistics()` take.
  virtual std::uint64_t statistics_bytes() const = 0;

  /// `save` returns everything that determines the rest of the summary; call it only when
  /// `aligned()`. `restore` returns false for data that `save` cannot have written for the same
  /// scene and description; `to` may differ.
  virtual std::string save() const = 0;
  virtual bool restore(std::string_view saved) = 0;

  /// Returns the number of steps so far, summed over all members.
  virtual std::int64_t computed_steps() const = 0;
  /// Returns the sum of Simulation::map_steps over all members, for the steps that this object has
  /// computed; without the shortened steps to events and times.
  virtual std::int64_t map_steps() const = 0;
  /// Whether the summary reads samples at every step of the grid or looks for events. This takes
  /// work beside that of the steps.
  virtual bool reads_on_the_way() const = 0;

  virtual const SummaryDescription& description() const = 0;
};

}  // namespace stiefel
