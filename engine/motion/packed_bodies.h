#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "stiefel/simulation.h"

namespace stiefel {

/// As many bodies in three or four dimensions as a vector register has lanes, advanced together.
/// Each has the bits that it has alone, because lanes are independent and run the same source code.
/// A step that is not easy for some of them (an equation that converges slowly, a state that is not
/// finite) is left to their own Simulations.
class PackedBodies {
 public:
  /// Number of steps that all bodies took, and the lanes that took one step more.
  struct Progress {
    std::int64_t steps;
    unsigned further;
  };

  virtual ~PackedBodies();
  virtual int lanes() const = 0;
  /// Advances by up to `steps`, and stops before a step that is not easy for all bodies. `states`
  /// holds what Simulation::save gives for each body, one after another. Thread-safe.
  virtual Progress advance(std::span<double> states, std::int64_t steps) const = 0;
};

class FlatBodies;

/// How scenes of a system advance together, for SystemEntry::packs.
struct Packs {
  /// Whether a scene can advance together with others like it.
  bool (*takes)(const Scene&);
  /// Returns the number of lanes on this machine for scenes like this one.
  int (*lanes)(const Scene&);
  /// Packs at most as many scenes of one ensemble as there are lanes; lanes without a scene repeat
  /// the last one. `start` holds their states at step 0.
  std::unique_ptr<PackedBodies> (*make)(std::span<const Scene>, std::span<const double> start);
  /// Whether the members of an ensemble can be numbers, and these.
  bool (*is_flat)(const Scene& ensemble);
  std::shared_ptr<const FlatBodies> (*flat)(const Scene& ensemble);
};

/// Returns Packs::lanes of a scene's system, which must have packs.
int body_lanes(const Scene& scene);
/// Whether a scene can advance together with others like it: its system has packs, which take it.
bool can_be_packed(const Scene& scene);

/// Returns a rough number of nanoseconds for a step of an ensemble, for slicing: `packed` of its
/// members can be packed. `one` is the simulation of its first member, the scene `first`.
double step_cost(const Scene& first, const Simulation& one, std::size_t members,
                 std::size_t packed);

}  // namespace stiefel
