#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/simulation/catalogue/methods/recommendation.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {

class SceneDraft;
struct MotionStart;
struct Representation;
struct TwoForm;
struct VectorField;

/// The meaning of `Simulation::rate` for a scene in three dimensions.
enum class Rate {
  other,
  angular_speed,  ///< |omega|
  frame_speed,    ///< ||Q'||_F, of a 3 x 3 frame sqrt(2) |omega|
};

/// The size that the work of a step depends on (step_weight.h).
struct FrameSize {
  double n, N;
};

/// A system in the catalogue: everything that the library knows of it. No other file asks for a
/// system by its name. What is null or empty the system goes without.
struct SystemEntry {
  /// Its entry in Describe; `forms` is filled in from `two_forms`.
  SystemInfo info;
  /// Checks a description, and fills in inertia and blocks of the scene that comes of it.
  void (*check)(SceneDraft&);
  std::unique_ptr<Simulation> (*make)(const Scene&);

  /// The methods of scenes that name none, in order; the last takes every scene. Without any, the
  /// method that chooses its own steps, with its default tolerance.
  std::span<const Recommendation> recommended = {};
  /// The rule by which a method refuses this scene; empty if it accepts it.
  std::string (*refusal)(const Scene&, std::string_view method) = nullptr;
  /// On its states, the symplectic one first.
  std::vector<const TwoForm*> two_forms = {};
  /// The Dirac bracket of functions of its state (Q, P), [RB] (3.15).
  bool dirac_bracket = false;
  /// The correspondence with (Q, M) and (Q, S).
  const Representation* representation = nullptr;
  /// For references: the start of the Taylor series of its motion; or, for a system without one,
  /// its vector field in extended precision (vector_field.h).
  const MotionStart* motion = nullptr;
  VectorField (*vector_field)(const Scene&) = nullptr;
  Rate rate = Rate::other;
  /// For a discrete system: the continuous system of the same state, defined for every step.
  std::string_view continuous = {};
  /// Its bodies of three and four dimensions go together in vector registers.
  bool packed = false;
  /// The size of a scene for step_weight.h. Null: the rows of its first block, or N where the scene
  /// goes without, and N.
  FrameSize (*size)(const Scene&) = nullptr;
  /// For tests and weights: a seeded scene without method and step, and the step at which the
  /// errors of a method of order 4 are small but seen. Null: tests/support/scenes/any_scene.cc has
  /// scenes of it.
  SceneDescription (*example)(unsigned seed) = nullptr;
  double example_step = 0.1;
};

/// All systems, those of systems.inc first. Built once.
const std::vector<SystemEntry>& system_entries();
/// Null if there is none of that name.
const SystemEntry* system_entry(std::string_view name);

/// Adds a system to the catalogue from outside the library. Before anything else is asked of the
/// catalogue: throws std::logic_error afterwards, and for a name that is taken. Not thread-safe.
void register_system(SystemEntry entry);

}  // namespace stiefel
