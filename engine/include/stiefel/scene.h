#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stiefel/arithmetic.h"
#include "stiefel/violation.h"

namespace stiefel {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// A method as requested; Scene::resolve fills in absent fields.
struct MethodDescription {
  std::string name;
  std::optional<int> order;
  std::optional<int> substeps;
  std::string arithmetic;                ///< "compensated", "plain" or empty
  std::optional<double> tolerance = {};  ///< for methods that choose their own steps
  std::string scalar = {};               ///< "double", "float" or empty
};

/// A body in three dimensions in the caller's axes. Either `inertia_tensor` (Ixx, Iyy, Izz, Ixy,
/// Ixz, Iyz: matrix entries) or the principal `moments` is given, in kg m². `attitude` is
/// Hamilton's quaternion w, x, y, z, body to space; `angular_velocity` is in rad/s in body axes.
struct BodyDescription {
  std::vector<double> inertia_tensor;
  std::vector<double> moments;
  std::vector<double> attitude;
  std::vector<double> angular_velocity;
};

/// A block of the initial state. It is real when `imaginary` is empty; otherwise `imaginary` has
/// the shape of `values`.
struct Block {
  Block() = default;
  Block(RowMatrix real, RowMatrix imaginary_part = {})
      : values(std::move(real)), imaginary(std::move(imaginary_part)) {}
  template <class Derived>
  Block(const Eigen::MatrixBase<Derived>& real) : values(real) {}

  RowMatrix values, imaginary;
};

/// A scene as a caller writes it, unchecked.
struct SceneDescription {
  std::string system;
  std::optional<MethodDescription> method;
  std::vector<double> inertia, inertia_u, inertia_v;
  std::map<std::string, Block> initial;
  std::optional<BodyDescription> body;
  std::optional<double> epsilon;    ///< for the symmetric systems
  std::optional<double> parameter;  ///< μ, for the parametric systems
  std::optional<double> step;
  /// In place of a method: the largest error up to `horizon`, for which resolve_choosing
  /// (tradeoff.h) chooses the method.
  std::optional<double> tolerance = {};
  std::optional<double> horizon = {};  ///< the time of interest, > 0 whatever the step's sign
  std::optional<int> members = {};     ///< number of members, for an ensemble
};

/// A 3D body brought to its principal axes: I = R diag(moments) Rᵀ, det R = +1.
/// Q_caller = Q Rᵀ, M_caller = R M Rᵀ. A diagonal tensor keeps its axes and their order, R = I.
struct PrincipalAxes {
  Eigen::Vector3d moments;
  Eigen::Matrix3d rotation;
};

class Members;

/// Everything that determines a motion. Immutable, and always valid: only `resolve` makes one.
/// Resolving a resolved description gives the same scene, bit for bit.
class Scene {
 public:
  /// Largest N where n = N, and largest n.
  static constexpr int max_dimension = 1024;
  /// Largest n·N where n < N.
  static constexpr int max_elements = 1 << 24;
  /// Largest number of members of an ensemble.
  static constexpr int max_members = 1 << 17;
  /// Largest max |QQᵀ − I| up to which Q is accepted and repaired, and largest | |attitude| − 1 |.
  static constexpr double frame_tolerance = 1e-6;
  /// Largest max |QQᵀ − I| for scenes that start from a computed state, which may have drifted.
  static constexpr double drift_tolerance = 1e-2;
  /// Largest max |M + Mᵀ| / max |M| up to which M is accepted and replaced by its skew part.
  static constexpr double skew_tolerance = 1e-10;
  /// The smallest top-level `tolerance`: the limit of double precision.
  static constexpr double least_tolerance = 1e-15;

  /// Checks a description and fills in its defaults. Returns the scene, or all violations at once.
  /// Repairs frames whose max |QQᵀ − I| is at most `largest_repair`.
  /// Simulates nothing: refuses a description of a continuous system without a method, with the
  /// reason METHOD_NOT_CHOSEN. `resolve_recommending` below accepts it, and resolve_choosing
  /// (tradeoff.h) also one with a tolerance. Throws Stopped (stop.h).
  static std::expected<Scene, Violations> resolve(SceneDescription description,
                                                  double largest_repair = frame_tolerance);

  /// Returns the scene with another method. Checks only the method, unless its scalar type has a
  /// narrower range. Throws Stopped (stop.h).
  std::expected<Scene, Violations> with(MethodDescription method) const;

  /// Returns the resolved description: what the caller gave, with every default filled in.
  const SceneDescription& description() const { return description_; }
  const std::string& system() const { return description_.system; }
  /// Empty for a discrete system.
  std::string method() const { return description_.method ? description_.method->name : ""; }
  int order() const { return description_.method ? description_.method->order.value_or(0) : 0; }
  int substeps() const {
    return description_.method ? description_.method->substeps.value_or(1) : 1;
  }
  /// The tolerance of a method that chooses its own steps; else 0.
  double tolerance() const {
    return description_.method ? description_.method->tolerance.value_or(0) : 0;
  }
  Arithmetic arithmetic() const {
    return description_.method && description_.method->arithmetic == "plain"
               ? Arithmetic::plain
               : Arithmetic::compensated;
  }
  /// Whether the state is kept and computed in single precision.
  bool in_float() const { return description_.method && description_.method->scalar == "float"; }
  double step() const { return *description_.step; }
  double time(std::int64_t step) const { return static_cast<double>(step) * *description_.step; }
  double epsilon() const { return description_.epsilon.value_or(1); }
  double parameter() const { return description_.parameter.value_or(0); }
  /// Returns N.
  int dimension() const { return static_cast<int>(inertia_.size()); }
  /// Returns λ_1..λ_N, for a body in its principal axes.
  const Eigen::VectorXd& inertia() const { return inertia_; }

  /// Returns a block of the initial state, in principal axes and repaired; 0 × 0 if the scene has
  /// none of that name.
  const Eigen::MatrixXd& block(const std::string& name) const;
  const Eigen::MatrixXd& Q() const { return block("Q"); }
  const Eigen::MatrixXd& M() const { return block("M"); }
  bool has_frame() const { return Q().size() > 0; }
  /// N = 3 with a frame: the quaternion of Q, or of −Q when det Q = −1.
  const Eigen::Vector4d& attitude() const { return attitude_; }
  /// det Q = ±1.
  int determinant() const { return determinant_; }
  /// The principal axes of a scene given by `body`; else nullopt.
  const std::optional<PrincipalAxes>& axes() const { return axes_; }
  /// Returns the members of an ensemble, each as a scene; empty for a single motion. For an
  /// ensemble the other functions of this class return the data of the first member. The result
  /// must not outlive the scene.
  Members members() const;

 private:
  Scene() = default;
  friend class SceneDraft;

  SceneDescription description_;
  Eigen::VectorXd inertia_;
  std::map<std::string, Eigen::MatrixXd> blocks_;
  Eigen::Vector4d attitude_ = Eigen::Vector4d::UnitX();
  int determinant_ = 1;
  std::optional<PrincipalAxes> axes_;
};

/// Resolves a description as Scene::resolve does, after it has given a scene without method and
/// tolerance the recommended method of its system: with the number of substeps that keeps the error
/// small, for an ensemble in its fastest member. That number follows from the rate of the motion at
/// the start. A momentum alone with N = 4 and a geodesic with n = 1 are integrated over 4 and 16
/// rotations for it. Throws Stopped (stop.h).
std::expected<Scene, Violations> resolve_recommending(
    SceneDescription description, double largest_repair = Scene::frame_tolerance);

/// The members of an ensemble as scenes. A member is resolved each time it is asked for, which
/// takes some microseconds for a small one, so that an ensemble stores its numbers only once.
class Members {
 public:
  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// Member b, 0 <= b < size().
  Scene operator[](std::size_t b) const;
  Scene front() const { return (*this)[0]; }
  /// Members first ... first + count - 1.
  std::vector<Scene> range(std::size_t first, std::size_t count) const;

 private:
  friend class Scene;
  explicit Members(const SceneDescription& ensemble)
      : ensemble_(&ensemble), count_(static_cast<std::size_t>(ensemble.members.value_or(0))) {}

  const SceneDescription* ensemble_;
  std::size_t count_;
};

inline Members Scene::members() const { return Members(description_); }

/// Returns the warnings about an accepted scene, one sentence each; usually none.
///
/// A λ_i below 0 is a second moment of mass that no rigid body has; for N = 3, λ_3 < 0 means
/// I_1 + I_2 < I_3. Rounding errors in the moments of a flat body, where λ_3 = 0, give no warning.
/// A `body` that turns by more than half a turn in a step may have been given in degrees.
std::vector<std::string> warnings(const Scene& scene);

}  // namespace stiefel
