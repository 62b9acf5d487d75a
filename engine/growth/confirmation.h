#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/growth/lyapunov_run.h"

namespace stiefel {

/// A second motion over the same time, which shows whether growth is that of the flow: it starts
/// beside the first state, so that it is no single unstable motion, and its map is another one and
/// nearer to the flow. A map of order p moves the integrals of a flow by C h^p, and next to a
/// separatrix a change of so much makes chaos of regular motions: there the second motion must have
/// a change far below the square of its distance. A discrete system is a map, and so is its flow.
class Confirmation {
 public:
  /// How many motions are tried: one that sticks to regular ones for the whole time confirms
  /// nothing.
  static constexpr int most_attempts = LyapunovExponents::most_second_motions;
  /// The distance at which it starts, relative to the norms of the blocks.
  static constexpr double distance = 1e-4;
  /// The most steps that take the place of one step of the method.
  static constexpr int most_refinement = 4;
  /// The longest steps of order 8, times the rate of the fastest oscillation: they change integrals
  /// by some 1e-9.
  static constexpr double longest_step = 0.3;

  /// The first motion: its scene, its state at the first step, a unit tangent vector there, the
  /// steps between two orthonormalisations, their number, and the largest rate on the way.
  struct First {
    const Scene& scene;
    const Simulation& start;
    Eigen::MatrixXd direction;
    std::int64_t interval, intervals;
    double fastest;
    LyapunovDescription what;
  };
  /// Returns why no such motion can be made, else an empty text.
  std::string begin(const First& first);

  /// Advances by about so many steps of a scene whose steps cost `step_cost` (Simulation).
  RunStatus advance(double steps, double step_cost, const std::stop_token& stop);
  bool done() const { return run_->done(); }

  const LyapunovRun& run() const { return *run_; }
  /// Says how the motion moves: "variational of order 8, in steps of 0.1".
  const std::string& how() const { return how_; }

  /// Writes what is needed to go on, at the last end of an interval.
  std::vector<char> save() const;
  /// Goes on where `save` wrote the bytes of a motion that `begin` made of the same scene; else
  /// returns false and stays where it was.
  bool restore(const std::vector<char>& saved);

 private:
  std::unique_ptr<Simulation> motion_;
  std::unique_ptr<LyapunovRun> run_;
  std::vector<double> state_;  ///< at the last end of an interval
  std::string how_;
};

/// Returns the map of a confirmation: the closed form of the scene's system, else its method of the
/// highest order in steps of at most a quarter of the scene's.
Scene confirming_scene(const Scene& scene);

}  // namespace stiefel
