#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <string_view>
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
  std::optional<double> tolerance = {};  ///< of methods that choose their own steps
  std::string scalar = {};               ///< "double", "float" or empty
};

/// A body in three dimensions in the caller's axes. Inertia tensor (Ixx, Iyy, Izz, Ixy, Ixz, Iyz:
/// matrix entries) or principal moments, in kg m²; the attitude is Hamilton's quaternion w, x, y,
/// z, body to space; rad/s in body axes.
struct BodyDescription {
  std::vector<double> inertia_tensor;
  std::vector<double> moments;
  std::vector<double> attitude;
  std::vector<double> angular_velocity;
};

/// A block of the initial state. Real when `imaginary` is empty, else of the same shape.
struct Block {
  Block() = default;
  Block(RowMatrix real, RowMatrix imaginary_part = {})
      : values(std::move(real)), imaginary(std::move(imaginary_part)) {}
  template <class Derived>
  Block(const Eigen::MatrixBase<Derived>& real) : values(real) {}

  RowMatrix values, imaginary;
};

/// A scene as a caller writes it, unchecked. Its fields as data: scene_fields.h.
struct SceneDescription {
  std::string system;
  std::optional<MethodDescription> method;
  std::vector<double> inertia, inertia_u, inertia_v;
  std::map<std::string, Block> initial;
  std::optional<BodyDescription> body;
  std::optional<double> epsilon;    ///< of the symmetric systems
  std::optional<double> parameter;  ///< μ of the parametric systems
  std::optional<double> step;
  std::optional<double> tolerance = {};  ///< instead of a method: largest error up to `horizon`
  std::optional<double> horizon = {};    ///< the time of interest, > 0 whatever the step's sign
  std::string choice = {};               ///< of a resolved scene: why it has the method that it has
  std::optional<int> members = {};       ///< of an ensemble
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
  /// N when n = N, and n.
  static constexpr int max_dimension = 512;
  /// n·N when n < N.
  static constexpr int max_elements = 1 << 24;
  /// Largest number of members of an ensemble.
  static constexpr int max_members = 1 << 16;
  /// Q is accepted, and repaired, up to this max |QQᵀ − I|; the same for | |attitude| − 1 |.
  static constexpr double frame_tolerance = 1e-6;
  /// The bound for scenes that start from a computed state, which may have drifted.
  static constexpr double drift_tolerance = 1e-2;
  /// M is accepted, and its skew part taken, up to this max |M + Mᵀ| / max |M|.
  static constexpr double skew_tolerance = 1e-10;
  /// The smallest top-level `tolerance`: the limit of double precision.
  static constexpr double least_tolerance = 1e-15;

  /// Every violation at once, or the scene. Frames are repaired up to `largest_repair`. The
  /// violations are of the fields of `place`. Nothing is simulated: a description with a tolerance
  /// instead of a method is refused with reason METHOD_NOT_CHOSEN (resolve_choosing, tradeoff.h).
  static std::expected<Scene, Violations> resolve(SceneDescription description,
                                                  double largest_repair = frame_tolerance,
                                                  const Place& place = {});

  /// The scene with another method, without the tolerance that a method was chosen
  /// for. Nothing but the method is checked, unless its numbers have a narrower range.
  std::expected<Scene, Violations> with(MethodDescription method, const Place& place = {}) const;

  /// The resolved description: what the caller gave with every default filled in.
  const SceneDescription& description() const { return description_; }
  const std::string& system() const { return description_.system; }
  /// Empty for a discrete system.
  std::string method() const { return description_.method ? description_.method->name : ""; }
  int order() const { return description_.method ? description_.method->order.value_or(0) : 0; }
  int substeps() const {
    return description_.method ? description_.method->substeps.value_or(1) : 1;
  }
  double tolerance() const { return description_.method->tolerance.value_or(0); }
  Arithmetic arithmetic() const {
    return description_.method && description_.method->arithmetic == "plain"
               ? Arithmetic::plain
               : Arithmetic::compensated;
  }
  /// The state and all that is computed with it are numbers of single precision.
  bool in_float() const { return description_.method && description_.method->scalar == "float"; }
  double step() const { return *description_.step; }
  double time(std::int64_t step) const { return static_cast<double>(step) * *description_.step; }
  double epsilon() const { return description_.epsilon.value_or(1); }
  double parameter() const { return description_.parameter.value_or(0); }
  /// N.
  int dimension() const { return static_cast<int>(inertia_.size()); }
  /// λ_1..λ_N, in principal axes for a body.
  const Eigen::VectorXd& inertia() const { return inertia_; }

  /// A block of the initial state of the system, in principal axes, repaired; 0 × 0 if the scene
  /// goes without.
  const Eigen::MatrixXd& block(const std::string& name) const;
  const Eigen::MatrixXd& Q() const { return block("Q"); }
  const Eigen::MatrixXd& M() const { return block("M"); }
  bool has_frame() const { return Q().size() > 0; }
  /// N = 3 with a frame: the quaternion of Q, or of −Q when det Q = −1.
  const Eigen::Vector4d& attitude() const { return attitude_; }
  /// det Q = ±1.
  int determinant() const { return determinant_; }
  /// Only for a scene given by `body`.
  const std::optional<PrincipalAxes>& axes() const { return axes_; }
  /// The members of an ensemble, each as a scene, none of a single motion; the other functions of
  /// this class then return the data of the first member. Must not outlive the scene.
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

/// The members of an ensemble as scenes of their own. Each is resolved when it is asked for, which
/// takes some microseconds for a small one: an ensemble holds its numbers once, and no scene of
/// each member.
class Members {
 public:
  class Iterator;

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// Member b, 0 <= b < size().
  Scene operator[](std::size_t b) const;
  Scene front() const { return (*this)[0]; }
  /// Members first ... first + count - 1.
  std::vector<Scene> range(std::size_t first, std::size_t count) const;
  Iterator begin() const;
  Iterator end() const;

 private:
  friend class Scene;
  explicit Members(const SceneDescription& ensemble)
      : ensemble_(&ensemble), count_(static_cast<std::size_t>(ensemble.members.value_or(0))) {}

  const SceneDescription* ensemble_;
  std::size_t count_;
};

/// Gives each member by value.
class Members::Iterator {
 public:
  Iterator(const Members& members, std::size_t at) : members_(members), at_(at) {}
  Scene operator*() const { return members_[at_]; }
  Iterator& operator++() {
    ++at_;
    return *this;
  }
  bool operator!=(const Iterator& other) const { return at_ != other.at_; }

 private:
  Members members_;
  std::size_t at_;
};

inline Members Scene::members() const { return Members(description_); }
inline Members::Iterator Members::begin() const { return {*this, 0}; }
inline Members::Iterator Members::end() const { return {*this, count_}; }

/// The warnings about an accepted scene, one sentence each; usually none.
///
/// The motion is defined wherever λ_i + λ_j > 0, but λ_i is a second moment of mass: below 0 it
/// belongs to no rigid body. In three dimensions λ_3 < 0 is I_1 + I_2 < I_3. Rounding errors in the
/// moments of a flat body, where λ_3 = 0, give no warning.
std::vector<std::string> warnings(const Scene& scene);

}  // namespace stiefel
