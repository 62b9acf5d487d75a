#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/motion/recommendation.h"
#include "stiefel/catalogue.h"
#include "stiefel/price.h"

namespace stiefel {

class SceneDraft;
struct Body3;
struct BodyView;
struct GivenBody;
struct MotionStart;
struct Packs;
struct Representation;
struct Tangents;
struct TwoForm;

/// The meaning of `Simulation::rate` for a scene in three dimensions.
enum class Rate {
  other,
  angular_speed,  ///< |omega|
  frame_speed,    ///< ||Q'||_F, of a 3 x 3 frame sqrt(2) |omega|
};

/// Functions that return how fast a motion of a system changes, for SystemEntry::rates; null where
/// nothing asks for it.
struct MotionRates {
  /// For a body in three dimensions: returns the largest of |ω| along the whole motion and of the
  /// frequency λ of Jacobi's functions. Where the moments violate the triangle inequality, both may
  /// be many times |ω| at the start. 0 at rest.
  double (*turning)(const Scene&) = nullptr;
  /// For a body in three dimensions with Λ and the vector m of M: returns the complementary
  /// parameter 1 − k² of Jacobi's functions, in which its motion is expressed: 0 on the separatrix
  /// and for a rotation about the middle axis, 1 for a symmetric body and for a rotation about
  /// another axis.
  double (*separatrix)(const Eigen::Vector3d& lambda, const Eigen::Vector3d& m) = nullptr;
};

/// Members of an ensemble whose MotionRates::separatrix is below this bound are next to the
/// separatrix. Plain arithmetic then loses more than 1e-8 in 100 rotations: the error is about
/// 1e-14 divided by the parameter.
constexpr double next_to_separatrix = 1e-5;

/// A system in the catalogue: everything that the library knows about it. No other file refers to a
/// system by its name. A null or empty member means that the system does without. Of a system NAME
/// of systems.inc, NAME_entry() returns it.
struct SystemEntry {
  /// The system's entry in Describe. The catalogue fills in its `methods` and `forms`, from
  /// `methods` and `two_forms` of this entry.
  SystemInfo info;
  /// Checks a description, and fills in inertia and blocks of the resulting scene.
  void (*check)(SceneDraft&);
  /// Checks the numbers of a `body` alone and returns the body, or adds violations; null for
  /// systems without `body`.
  std::optional<Body3> (*body_of)(SceneDraft&, const GivenBody&) = nullptr;
  /// Makes the simulation of a scene, by its method.
  std::unique_ptr<Simulation> (*make)(const Scene&);
  /// Returns the methods that apply, and what they do to the invariants of `info`.
  std::vector<MethodOnSystem> (*methods)(const SystemInfo& info);
  /// Returns the rule by which one of these methods refuses a scene; empty if it accepts it.
  std::string (*refusal)(const Scene&, std::string_view method) = nullptr;

  /// Recommended methods for scenes that name none, in order; the last takes every scene. If empty,
  /// such scenes get the method that chooses its own steps, with its default tolerance.
  std::span<const Recommendation> recommended = {};
  /// Whether bodies in three dimensions move in single precision too, by the methods that can.
  bool in_float = false;
  /// Two-forms on the system's states, the symplectic one first.
  std::vector<const TwoForm*> two_forms = {};
  /// Whether the system has the Dirac bracket of functions of its state (Q, P), [RB] (3.15).
  bool dirac_bracket = false;
  /// The correspondence with (Q, M) and (Q, S).
  const Representation* representation = nullptr;
  /// The derivatives of its steps (tangent_map.h).
  const Tangents* tangents = nullptr;
  /// For a system that is the rigid body, or the discrete one, in other variables: those.
  BodyView (*view)(const Scene&) = nullptr;
  /// The system by which the prices of its steps are listed; empty: its own name.
  std::string_view priced_as = {};
  /// For references: the start of the Taylor series of the motion.
  const MotionStart* motion = nullptr;
  Rate rate = Rate::other;
  /// For a discrete system: the continuous system with the same state, which is defined for every
  /// step.
  std::string_view continuous = {};
  /// How its bodies of three and four dimensions advance together in vector registers.
  const Packs* packs = nullptr;
  /// How fast its motions change, for recommendations and warnings.
  const MotionRates* rates = nullptr;
  /// Returns the size by which the table of prices is read; null: `frame_size` (price.h).
  FrameSize (*size)(const Scene&) = nullptr;
  /// For tests and weights: returns a scene without method and step, seeded by `seed`;
  /// `example_step` is a step at which the errors of a method of order 4 are small but visible.
  /// Null: tests/support/scenes/any_scene.cc has scenes of the system.
  SceneDescription (*example)(unsigned seed) = nullptr;
  double example_step = 0.1;
};

/// Returns the systems of systems.inc, in its order. Built once.
const std::vector<SystemEntry>& system_entries();
/// Returns null if there is none of that name.
const SystemEntry* system_entry(std::string_view name);

}  // namespace stiefel
