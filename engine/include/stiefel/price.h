#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "stiefel/simulation.h"

namespace stiefel {

// What simulations cost, known before they run: work in instructions, as callgrind counts them, and
// bytes. A list has the instructions of a step of each method as a polynomial in the size, fitted
// to counted steps and within 25 % of them (engine/motion/step_prices.inc). It is the
// same on every CPU, so that every machine chooses the same method.

/// Returns the rough number of nanoseconds that so many instructions take.
constexpr double nanoseconds(double instructions) { return instructions / 5; }

/// The size of a scene, on which the work of a step depends.
struct FrameSize {
  double n, N;
};

/// Returns the size of a scene on which its prices depend: n is the number of rows of the first
/// block of its state, or N where the scene has none.
FrameSize frame_size(const Scene& scene);

/// Returns the work of one step of the map of a scene at h‖Ω‖ = 0.1. The work of a run is
/// `Simulation::map_steps()` times this number.
double step_weight(const Scene& scene);

/// Returns the work of one step at this h‖Ω‖ > 0 (`Simulation::rate` times the step of the map).
/// For an explicit method it is `step_weight`; for one that iterates, `step_weight` times a factor
/// known at some h‖Ω‖: between them a power law, beyond them the nearest.
double step_price(const Scene& scene, double h_omega);
/// Whether `step_price` depends on h‖Ω‖.
bool price_depends_on_rate(const Scene& scene);
/// Whether the list has an entry. Without one the work of a step is estimated.
bool is_weighed(const Scene& scene);

/// Returns the work of a map step of `members` members like `one`. Members that advance together in
/// vector registers cost the price of their packs on a machine with AVX2; every other member costs
/// `alone`.
double ensemble_step_price(const Scene& one, std::size_t members, double alone);

/// Returns the bytes that `make_simulation(scene)` and its first steps allocate, predicted from a
/// table of how many matrices of the scene's size each method keeps; for an ensemble the sum over
/// its members. This is an upper bound except for small objects:
/// tests/engine/programs/workspace_test.cc counts them.
std::size_t simulation_bytes(const Scene& scene);

/// Returns the bytes that the largest simulation of a scene with n x N blocks takes, whatever its
/// method.
std::size_t largest_simulation_bytes(double n, double N);

/// Returns the bytes of a resolved scene with this description, including its members and the
/// description itself.
std::size_t scene_bytes(const SceneDescription& description);

/// Returns the bytes of the arrays of a description.
std::size_t array_bytes(const SceneDescription& description);

/// What a simulation of a scene offers: its fields and sizes.
struct Outline {
  std::vector<Field> fields;
  std::size_t block_count = 0, saved_size = 0;
  double step_cost = 0;  ///< Simulation::step_cost
  bool direct = false;
  /// Whether the members of an ensemble are numbers, which Summary::prepare takes from a
  /// simulation.
  bool numbers = false;
};

/// Returns the indices of the fields that are reported where none are named: the variables in which
/// the scene is given. These are `quaternion` and `angular_velocity` for a scene with `body`,
/// otherwise the system's blocks, the first `block_count` of the fields that it offers.
std::vector<std::size_t> default_fields(const Scene& scene, const std::vector<Field>& offered,
                                        std::size_t block_count);

Outline outline_of(const Simulation& simulation);

/// Returns the outline of an ensemble without building its simulation. Calls `look` with members
/// and their simulations, one after another: with the first, and with all that can be unlike it.
/// Members that are bodies of `body` and advance together in vector registers are alike: their
/// fields are finite, and the price of their steps does not depend on the rate.
Outline outline_of(const Scene& ensemble,
                   const std::function<void(const Scene&, const Simulation&)>& look);

}  // namespace stiefel
