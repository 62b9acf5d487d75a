#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "stiefel/run_status.h"
#include "stiefel/scene.h"

namespace stiefel {

class InvariantList;

/// A field that can be sampled: "Q", "M", "Omega", "quaternion", ...; rows × cols numbers, for
/// complex fields each element as its real and imaginary part.
struct Field {
  std::string name;
  int rows = 0;
  int cols = 0;
  bool complex = false;
  int members = 0;  ///< of an ensemble, whose fields are written one member after another; else 0
  /// Numbers.
  int size() const { return rows * cols * (complex ? 2 : 1) * (members > 0 ? members : 1); }
};

/// A Map with its current State and step index. The state at step k has the same bits on every path
/// to it: by one call or many, or by `restore` from an earlier `save`. Not thread-safe; different
/// simulations may run on different threads.
class Simulation {
 public:
  virtual ~Simulation() = default;

  std::int64_t step() const { return step_; }
  /// The number of map steps so far: every substep counts, and for a method that chooses its
  /// substeps the rejected ones too. Work is this number times `step_weight`.
  virtual std::int64_t map_steps() const = 0;

  /// Advances by `steps` ≥ 0, or to the last good state before. Looks at `stop` before every step
  /// of the map, and where a method chooses its own steps before every attempt: then `cancelled`.
  /// No allocation after the first step.
  virtual RunStatus advance(std::int64_t steps, const std::stop_token& stop = {}) = 0;

  /// Whether each state follows directly from step 0, so that `advance` costs the same for any
  /// number of steps.
  virtual bool direct() const { return false; }

  /// The complete state, solver history and round-off carries included, and back again.
  /// `restore` expects exactly `saved_size()` numbers from a simulation of the same scene and
  /// build.
  virtual std::size_t saved_size() const = 0;
  virtual void save(std::span<double> out) const = 0;
  virtual void restore(std::int64_t step, std::span<const double> saved) = 0;

  /// The fields this scene offers, its system's blocks first.
  const std::vector<Field>& fields() const { return fields_; }
  /// How many of them are the blocks.
  std::size_t block_count() const { return block_count_; }
  /// Writes field `index`, row by row, in the caller's axes.
  virtual void write(std::size_t index, std::span<double> out) const = 0;

  /// A field by its name, of an ensemble the members' on top of each other. Throws
  /// std::invalid_argument for one that is not among `fields()`.
  Eigen::MatrixXd get(std::string_view name) const;

  /// The invariants at the current state, computed in extended precision where that is cheap.
  virtual void invariants(InvariantList& out) const = 0;
  /// max |QQᵀ − I|; nothing for a state without a frame.
  virtual std::optional<double> orthogonality() const = 0;
  /// The rate of the motion, 1/time: ‖Ω‖, or ‖Q̇‖ where n < N.
  virtual double rate() const = 0;

  /// The largest |h| ≤ limit for which a step from the current state has a solution, to 1e-3; empty
  /// for a map that is defined for every h.
  virtual std::optional<double> largest_step(double limit) const = 0;

  /// One step of the map, without its history, from any state x near the manifold, blocks stacked
  /// by rows; nothing where it has none, and for states that are no matrices of blocks.
  virtual std::optional<Eigen::MatrixXd> image(const Eigen::MatrixXd& x) const = 0;

  /// The members of an ensemble, all at `step()`; empty for a single motion.
  virtual std::span<const std::unique_ptr<Simulation>> members() const { return {}; }

  /// A rough count of nanoseconds a step takes (`direct`: an advance), from N and the method alone:
  /// for slicing, not timing.
  virtual double step_cost() const = 0;

 protected:
  std::int64_t step_ = 0;
  std::vector<Field> fields_;
  std::size_t block_count_ = 0;
};

/// The simulation of a scene, at step 0.
std::unique_ptr<Simulation> make_simulation(const Scene& scene);

/// How many threads all ensembles of this process may use; all cores unless told.
void limit_ensemble_threads(int threads);

/// One sentence for people; empty when reached.
std::string to_sentence(const RunStatus& status);
/// One sentence for people, empty when reached. It names a method that accepts the scene if the
/// scene's own does not.
std::string to_sentence(const RunStatus& status, const Scene& scene);

/// The rate (`Simulation::rate`) at the last good state, where `last` is; of an ensemble that of
/// the member that ended the run.
double rate_at(const RunStatus& status, const Simulation& last);

/// One sentence for people, empty when reached: with what takes the scene where its method does not
/// and, where a step left the domain of a body in three dimensions, by how many degrees it turns
/// the body at that rate.
std::string to_sentence(const RunStatus& status, const Scene& scene, double rate);

}  // namespace stiefel
