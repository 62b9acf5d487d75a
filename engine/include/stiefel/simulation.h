#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "stiefel/crew.h"
#include "stiefel/run_status.h"
#include "stiefel/scene.h"

namespace stiefel {

class InvariantList;

/// A field that can be sampled: "Q", "M", "Omega", "quaternion", ... It has rows × cols elements;
/// an element of a complex field is two numbers, its real and its imaginary part.
struct Field {
  std::string name;
  int rows = 0;
  int cols = 0;
  bool complex = false;
  /// Number of members of an ensemble, whose fields are written one member after another; else 0.
  int members = 0;
  /// Whether the elements are Euler angles, of which the first and the last jump by 2π.
  bool angles = false;
  /// Returns how many numbers the field has.
  int size() const { return rows * cols * (complex ? 2 : 1) * (members > 0 ? members : 1); }
};

// A scene that lists the field `quaternion` also has Euler angles and their rates in every
// sequence, "euler_angles_ZXZ" and "euler_rates_xyz". They are not listed; their indices are above
// all others.

/// Returns the index of a field, for `Simulation::write`; nullopt if a scene that lists these
/// fields has none of that name.
std::optional<std::size_t> find_field(const std::vector<Field>& listed, std::string_view name);
/// Returns the field with an index that `find_field` returned, or below listed.size().
Field field_at(const std::vector<Field>& listed, std::size_t index);
/// Returns field_at(listed, index).size().
std::size_t field_size(const std::vector<Field>& listed, std::size_t index);
/// Returns the names of all fields in words: "Q, M, euler_angles_SEQUENCE".
std::string field_names(const std::vector<Field>& listed);

/// A Map with its current State and step index. The state at step k has the same bits however it
/// was reached: by one call or many, or by `restore` from an earlier `save`. Not thread-safe;
/// different simulations may run on different threads.
class Simulation {
 public:
  virtual ~Simulation() = default;

  std::int64_t step() const { return step_; }
  /// Returns the number of map steps so far. Every substep counts; for a method that chooses its
  /// substeps, rejected ones count too. run_work (error_estimate.h) gives the work that they take.
  virtual std::int64_t map_steps() const = 0;

  /// Advances by `steps` ≥ 0, or stops at the last good state on the way. Checks `stop` before
  /// every step of the map, and before every attempt of a method that chooses its own steps; a stop
  /// request ends the run with `cancelled`. Does not allocate after the first step.
  virtual RunStatus advance(std::int64_t steps, const std::stop_token& stop = {}) = 0;

  /// Advances like `advance`, in slices between which the caller can do something else: by at least
  /// one step and at most `steps` ≥ 1. `slice` is the number of steps whose work each thread does
  /// in one call; it may be a fraction for an ensemble, which moves a part of its members in each
  /// call. Returns nothing while members are on their way: the next call, with the same `steps`,
  /// moves others. Until a call returns a status, only this function, `step` and `turn_back` may be
  /// called.
  virtual std::optional<RunStatus> advance_slice(std::int64_t steps, double slice,
                                                 const std::stop_token& stop = {});
  /// Returns to the state at `step()` when members are on their way.
  virtual void turn_back() {}

  /// Whether each state is computed directly from step 0, so that `advance` costs the same for any
  /// number of steps.
  virtual bool direct() const { return false; }

  /// `save` writes the complete state, including the solver's history and the carried rounding
  /// errors, as `saved_size()` numbers; `restore` reads it back. `restore` expects exactly
  /// `saved_size()` numbers from a simulation of the same scene and build.
  virtual std::size_t saved_size() const = 0;
  virtual void save(std::span<double> out) const = 0;
  virtual void restore(std::int64_t step, std::span<const double> saved) = 0;

  /// Returns the fields that this scene lists; the system's blocks come first.
  const std::vector<Field>& fields() const { return fields_; }
  /// Returns how many of the fields are blocks.
  std::size_t block_count() const { return block_count_; }
  /// Writes field `index`, row by row, in the caller's axes.
  virtual void write(std::size_t index, std::span<double> out) const = 0;

  /// Returns a field by its name; for an ensemble the members' matrices are stacked. Throws
  /// std::invalid_argument for a name that `find_field` does not find.
  Eigen::MatrixXd get(std::string_view name) const;

  /// Computes the invariants at the current state, in extended precision where that is cheap.
  virtual void invariants(InvariantList& out) const = 0;
  /// Returns max |QQᵀ − I|; nullopt for a state without a frame.
  virtual std::optional<double> orthogonality() const = 0;
  /// Returns the rate of the motion, 1/time: ‖Ω‖, or ‖Q̇‖ where n < N.
  virtual double rate() const = 0;

  /// Returns the largest |h| ≤ limit for which a step from the current state has a solution, to
  /// 1e-3; nullopt for a map that is defined for every h.
  virtual std::optional<double> largest_step(double limit) const = 0;

  /// Returns one step of the map, without its history, from any state x near the manifold, with the
  /// blocks stacked by rows. Returns nullopt where the step has no solution, and for states that
  /// are not matrices of blocks.
  virtual std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd& x) const = 0;

  /// Returns the members of an ensemble, all at `step()`; empty for a single motion.
  virtual std::span<const std::unique_ptr<Simulation>> members() const { return {}; }

  /// Returns a rough estimate of the nanoseconds that a step takes (if `direct()`, an advance),
  /// from its price (stiefel/price.h). It serves to slice work, not to predict times.
  virtual double step_cost() const = 0;

 protected:
  std::int64_t step_ = 0;
  std::vector<Field> fields_;
  std::size_t block_count_ = 0;
};

/// Returns the simulation of a scene, at step 0. Throws Stopped (stop.h).
std::unique_ptr<Simulation> make_simulation(const Scene& scene);

/// Describes the status in one sentence for people; empty when it is `reached`. With a scene, the
/// sentence also names a method that can go on where the scene's own cannot. With the rate too, and
/// if a step of a body in three dimensions left the domain, it says by how many degrees the step
/// turns the body.
std::string to_sentence(const RunStatus& status);
std::string to_sentence(const RunStatus& status, const Scene& scene,
                        double rate = std::numeric_limits<double>::quiet_NaN());

/// Returns the rate (`Simulation::rate`) at the last good state, which `last` holds; for an
/// ensemble, the rate of the member that ended the run.
double rate_at(const RunStatus& status, const Simulation& last);

}  // namespace stiefel
