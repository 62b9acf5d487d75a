#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "stiefel/conservation.h"

namespace stiefel {

class Scene;
struct MethodDescription;

// The catalogue describes systems and methods as data, for people and for programs: what a scene
// may contain, what its simulation reports, and what each method keeps. All strings are constants
// of the program. Names are those of scenes and replies.
//
// A shape is text such as "N x N", "n x N" or "1 x 3": rows times columns of a single motion. N is
// the number of λ_i and n the number of rows of a frame. A source is a paper and its equation,
// "[RB] (2.2)", and a file a path in the project; either may be empty.

/// Returns the name of the enumerator.
std::string_view to_string(Conservation conservation);

/// What a method declares about one invariant of one system.
struct Preservation {
  std::string_view invariant;  ///< a name among SystemInfo::invariants
  Conservation conservation;
};

struct MethodInfo {
  std::string_view name;  ///< MethodDescription::name
  std::string_view summary;
  std::string_view source;
  std::string_view file;
  /// The values that MethodDescription::order may have, ascending. One value for a method without a
  /// choice of order; empty for a closed form, which has no order.
  std::vector<int> orders;
  int default_order;  ///< the order of a scene that gives none; 0 for a closed form
  bool reversible;    ///< whether a step by −h undoes a step by h
  /// The default of MethodDescription::tolerance; 0 for methods that take steps of a fixed size.
  double default_tolerance;
};

/// A block of the initial state: a matrix in SceneDescription::initial.
struct BlockInfo {
  std::string_view name;
  std::string_view shape;
  /// Whether every scene must have the block. The description tells what may replace one that is
  /// not required.
  bool required;
  std::string_view description;
};

/// A field that a simulation may report (Simulation::fields). The description says which scenes
/// have it, where not all do.
struct FieldInfo {
  std::string_view name;
  std::string_view shape;
  std::string_view description;
};

/// A family of invariants, one of stiefel::family (invariant_names.h) for a system of the library.
struct InvariantInfo {
  std::string_view name;
  std::string_view formula;  ///< in the names of blocks and fields: "Q M Q^T"
  std::string_view source;
};

/// A two-form on the states of a system; evaluate_form (diagnosis.h) evaluates it.
struct FormInfo {
  std::string_view name;
  std::array<std::string_view, 2> blocks;  ///< the two blocks of its tangent vectors
  std::string_view formula;
  std::string_view source;
};

/// What a method offers on one system. The name is empty for a discrete system, which takes no
/// method: its map then declares what it keeps.
struct MethodOnSystem {
  std::string_view method;
  std::vector<Preservation> preserves;  ///< one element for each invariant that is declared
  std::string_view where = {};          ///< `takes` in words, "N = 3"; empty: in every scene
  /// Whether the method accepts a scene with this Λ; null: it accepts every one.
  bool (*takes)(const Eigen::VectorXd& lambda) = nullptr;
  bool in_float = false;  ///< for N = 3 offered in single precision too
  /// Whether its steps have a derivative (linearization.h); that of `exact` is for N = 3.
  bool has_tangent = false;
};

/// How the frame of a body moves. On the left Q̇ = QΩ, where Q takes body to space and Ω is in body
/// axes; on the right Q̇ = ΩQ, where Q takes space to body. The frame of any other system: none.
enum class Side { none, left, right };

struct SystemInfo {
  std::string_view name;  ///< SceneDescription::system
  std::string_view summary;
  std::string_view equations;  ///< "Q' = Q Omega, M' = [M, Omega]"
  std::string_view source;
  std::string_view file;
  bool discrete;  ///< whether the system is a map by itself, which takes no method
  std::vector<BlockInfo> blocks;
  std::vector<FieldInfo> fields;
  std::vector<InvariantInfo> invariants;
  std::vector<MethodOnSystem> methods;  ///< for a discrete system one element, without a name
  std::vector<FormInfo> forms;          ///< the symplectic form first
  Side side = Side::none;
  /// The block of the initial state that holds the momentum: M = ΛΩ + ΩΛ of a body; of a frame S =
  /// Q̇Λ, P = S or M = QᵀS − SᵀQ; p = q̇Λ of an ellipsoid. Empty: none.
  std::string_view momentum = {};
  /// The name of the velocity in these formulas: Omega, Qdot, or the block qdot. Empty for a
  /// discrete system, and where there is no momentum.
  std::string_view velocity = {};
};

/// A method, and the scenes of a system that get it when they name neither a method nor a
/// tolerance. Attitude and momentum then stay within 1e-8 relative over 100 rotations (on V(n, N)
/// times the condition of the motion), at a few times the least work that any method needs for it.
struct Recommendation {
  std::string_view where = {};  ///< "N = 3"; empty: every scene
  /// Whether the recommendation is for a scene; null: for every scene.
  bool (*takes)(const Scene&) = nullptr;
  bool members_only = false;  ///< whether it is for the members of an ensemble alone
  std::string_view method;
  int order = 0;  ///< 0 for a closed form
  std::string_view arithmetic = "plain";
  double tolerance = 0;  ///< for methods that choose their own steps, else 0
  /// Bound for a substep h, which determines the number of substeps: on |h|‖Ω‖ in the initial
  /// state, for a body in three dimensions on |h| times its largest turning rate
  /// (MotionRates in engine/motion/system_entry.h). 0: no bound.
  double largest_h_omega = 0;

  /// Returns the method with one substep.
  MethodDescription description() const;
  /// Returns the least number of substeps that keeps a scene, which has a method, within the bound
  /// above.
  int substeps(const Scene& scene) const;
};

/// Returns the recommendations of a continuous system, in order; the last takes every scene. Empty
/// for any other name.
std::vector<Recommendation> recommended(std::string_view system);

/// All systems and methods.
struct Catalogue {
  std::vector<SystemInfo> systems;
  std::vector<MethodInfo> methods;

  /// Return null if there is none of that name.
  const SystemInfo* system(std::string_view name) const;
  const MethodInfo* method(std::string_view name) const;
};

/// Returns the catalogue, which the first call builds and nothing changes afterwards. May be called
/// from several threads.
const Catalogue& catalogue();

}  // namespace stiefel
