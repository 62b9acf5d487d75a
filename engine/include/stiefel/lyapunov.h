#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>

#include "stiefel/run_status.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/violation.h"

namespace stiefel {

/// What a LyapunovExponents computes.
struct LyapunovDescription {
  std::int64_t from = 0, to = 0;
  /// The number k of exponents, the largest ones; 0: all.
  std::int64_t count = 0;
  /// Steps between two orthonormalisations. 0: as many as the motion at `from` takes for about one
  /// radian.
  std::int64_t interval = 0;
  /// Of the random first vectors.
  std::uint64_t seed = 0;
};

/// What the growth says of a motion. "Chaotic" speaks of the flow: a second motion, which starts
/// beside this one and moves by a map nearer to the flow, grows alike over the whole time. Of a
/// discrete system it speaks of the map. "Regular" speaks of the computed steps.
enum class MotionKind : std::uint8_t { undecided, regular, chaotic };

/// The Lyapunov exponents of a motion, in 1/time, from the growth of k tangent vectors. A vector is
/// measured by |δQ|² + n|δM|²/|M|², with the norms of the blocks at the first step, so that the
/// choice of units does not matter.
///
///     S_i(t) = Σ ln r_ii over the intervals,   λ_i(t) = S_i(t) / t,
///     GALI_j(t) = volume of the first j vectors, each of length 1 but not orthonormalised
///               = exp(Σ_{i ≤ j} (S_i − ln |v_i|)), which has no floor of rounding.
///
/// The states and their bits are those of the simulation. The numbers depend on the scene and the
/// description alone, so that a run that `save` interrupted has the bits of an unbroken one.
class LyapunovExponents {
 public:
  /// The least number of intervals from `from` to `to`, so that errors can be told.
  static constexpr std::int64_t least_intervals = 20;

  static constexpr int most_second_motions = 2;

  using Made = std::expected<std::unique_ptr<LyapunovExponents>, Violations>;

  /// Refuses ensembles, methods without a tangent, and descriptions that do not fit. `start` is at
  /// `what.from`. Throws Stopped (stop.h), as do the functions below.
  static Made make(const Scene& scene, const LyapunovDescription& what, const Simulation& start);
  /// Returns the step at which `save` wrote the bytes; −1 if they are not of that kind.
  static std::int64_t saved_step(std::string_view saved);
  /// Goes on where `save` wrote the bytes, with a motion at that step. `what.to` may differ from
  /// the one that was saved. Refuses bytes of another description.
  static Made resume(const Scene& scene, const LyapunovDescription& what, std::string_view saved,
                     const Simulation& now);
  virtual ~LyapunovExponents() = default;

  /// Writes what is needed to go on, at the last end of an interval, as bytes.
  virtual std::string save() const = 0;

  /// Advances `motion` by at most about `steps` steps; after `to` was reached, the second motion by
  /// steps of about the same cost, where the verdict needs it.
  virtual RunStatus advance(Simulation& motion, std::int64_t steps,
                            const std::stop_token& stop = {}) = 0;
  /// Whether the verdict is known, or the motion has ended early.
  virtual bool done() const = 0;

  /// The step of the numbers: the last end of an interval, or `to`.
  virtual std::int64_t step() const = 0;
  virtual std::int64_t interval() const = 0;
  /// The number of steps that were made, those of the second motion included.
  virtual std::int64_t computed_steps() const = 0;
  /// The number of steps that are covered since `from`, up to the end of an interval, by the motion
  /// and by second ones, of which there are at most `most_second_motions`.
  virtual std::int64_t covered_steps() const = 0;

  /// λ_i(t), i = 1 … k.
  virtual Eigen::VectorXd exponents() const = 0;
  /// The half-widths of 95 % intervals: batch means by blocking [FlyvbjergPetersen1989], the
  /// batches doubled down to 8 of them and their rise continued (docs/lyapunov.md), and ln(1 +
  /// ωt)/t, ω the rate at the first step, which growth by a factor t contributes.
  virtual Eigen::VectorXd errors() const = 0;
  /// ln GALI_2 … ln GALI_k.
  virtual Eigen::VectorXd log_gali() const = 0;

  virtual MotionKind kind() const = 0;
  /// Says in words and numbers why the motion is of that kind.
  virtual std::string reason() const = 0;
};

/// Returns an upper bound of the bytes of a LyapunovExponents for states of `size` numbers; 0 for a
/// system without tangents.
std::uint64_t lyapunov_bytes(const Scene& scene, const LyapunovDescription& what,
                             std::int64_t size);

}  // namespace stiefel
