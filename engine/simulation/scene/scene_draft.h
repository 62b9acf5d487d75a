#pragma once

#include <expected>
#include <limits>

#include "engine/linalg/arithmetic/to_text.h"
#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

/// "3 x 4".
std::string shape_text(Eigen::Index rows, Eigen::Index cols);

/// A description during its check, and the resulting scene. A system's own check reads `given()`,
/// collects violations and fills in inertia and blocks; the rest is common.
class SceneDraft {
 public:
  SceneDraft(SceneDescription description, double largest_repair, const Place& place)
      : largest_repair_(largest_repair), place_(place) {
    scene_.description_ = std::move(description);
  }
  /// A draft of a valid scene, to be changed.
  SceneDraft(Scene scene, const Place& place)
      : scene_(std::move(scene)), largest_repair_(Scene::drift_tolerance), place_(place) {}

  // Defined in catalogue/resolve.cc, because they need the catalogue:

  /// Checks system, method and step, and lets the system check what is its own.
  void check();
  /// The scene once it is checked, with what was left open filled in.
  std::expected<Scene, Violations> resolve();
  /// This checked scene with another method.
  std::expected<Scene, Violations> with(MethodDescription method);

  SceneDescription& given() { return scene_.description_; }
  const Scene& scene() const { return scene_; }
  double largest_repair() const { return largest_repair_; }
  /// 0, which is refused, when the description has none.
  double step() { return given().step.value_or(0); }
  bool sound() const { return violations_.empty(); }
  const Violations& violations() const { return violations_; }
  /// `field` is the description's own: "initial.Q".
  void refuse(const std::string& field, std::string value, std::string rule);

  /// False, with a violation at the element, unless all are finite.
  bool all_finite(const std::string& field, const std::vector<double>& values);
  /// Refuses `field` of the scene unless it is absent.
  void refuse_if(bool present, const std::string& field);

  /// Takes over `inertia` if it has `least` to `most` finite numbers.
  bool set_inertia(std::size_t least = 2, std::size_t most = Scene::max_dimension);
  /// λ_i + λ_j > 0 for i ≠ j; what n = N needs.
  void check_inertia_sums();
  /// λ_i > 0; what n < N needs.
  void check_inertia_positive();

  /// Refuses blocks that the system does not have, and imaginary parts unless it is complex.
  void check_block_names(bool complex = false);
  bool has_block(const std::string& name) { return given().initial.contains(name); }
  /// The block, finite and of that shape; null with a violation, or without one if it is absent and
  /// not required.
  const RowMatrix* block(const std::string& name, Eigen::Index rows, Eigen::Index cols,
                         bool required = true);

  void set_block(const std::string& name, Eigen::MatrixXd value);
  /// Refuses a block with elements that are too large to compute with.
  bool check_size(const std::string& name, const RowMatrix& block);
  /// A block with orthonormal rows, repaired within largest_repair.
  void set_frame(const std::string& name, const RowMatrix& Q);
  /// A skew block, its skew part taken within Scene::skew_tolerance.
  void set_skew(const std::string& name, const RowMatrix& M);
  void set_body(const PrincipalAxes& axes, const Eigen::Vector4d& attitude,
                const Eigen::VectorXd& inertia, const Eigen::MatrixXd& M);

 private:
  void check_step();
  void check_method();
  void check_choice();
  void recommend();
  void check_order(const MethodInfo& info);
  void check_reach();
  void check_tolerance(const MethodInfo& info);
  void check_scalar();

  Scene scene_;
  double largest_repair_;
  const Place& place_;
  const SystemInfo* system_ = nullptr;
  Violations violations_;
};

}  // namespace stiefel
