#pragma once

#include <expected>
#include <span>
#include <string_view>

#include "engine/numbers/to_text.h"
#include "engine/scene/given_body.h"
#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Writes a shape: "3 x 4".
std::string shape_text(Eigen::Index rows, Eigen::Index cols);

/// A description while it is checked, and the resulting scene. The check of a system reads
/// `given()`, collects violations and fills in inertia and blocks; the checks here are common to
/// all systems. motion/resolve.h adds those that need the catalogue.
class SceneDraft {
 public:
  SceneDraft(SceneDescription description, double largest_repair)
      : largest_repair_(largest_repair) {
    scene_.description_ = std::move(description);
  }
  /// Starts from a valid scene that is to be changed.
  SceneDraft(Scene scene, double largest_repair = Scene::drift_tolerance)
      : scene_(std::move(scene)), largest_repair_(largest_repair) {}

  /// Sets the system whose blocks and name the checks below use.
  void set_system(const SystemInfo& system) { system_ = &system; }
  /// Returns the scene, or the violations if there are any. Call it last.
  std::expected<Scene, Violations> take();

  SceneDescription& given() { return scene_.description_; }
  const Scene& scene() const { return scene_; }
  double largest_repair() const { return largest_repair_; }
  /// Returns the step, or 0, which is refused, when the description has none.
  double step() { return given().step.value_or(0); }
  bool sound() const { return violations_.empty(); }
  const Violations& violations() const { return violations_; }
  /// Adds a violation. `field` is the description's own: "initial.Q".
  void refuse(std::string_view field, std::string value, std::string rule);
  void refuse(Violation violation) { violations_.push_back(std::move(violation)); }
  void forget_violations() { violations_.clear(); }

  void check_step();
  /// Returns whether all values are finite; adds a violation for the first element that is not.
  bool all_finite(std::string_view field, std::span<const double> values);
  /// Refuses a number, `what` in words, whose square would over- or underflow.
  bool check_number(std::string_view field, std::string_view what, double x);
  /// Refuses a size whose square would overflow.
  bool check_size(std::string_view field, std::string_view what, double size);
  /// Refuses a velocity, 1/time, that is too large to compute with, and a step in which it turns a
  /// frame by an angle without digits.
  bool check_velocity(std::string_view field, std::string_view what, double size);
  /// Refuses a momentum that is too large to compute with, or whose Ω = J⁻¹(M) is. `field` is where
  /// the scene gives it.
  bool check_momentum(const std::string& field, const Eigen::MatrixXd& M);
  /// Adds a violation of `field` if it is present.
  void refuse_if(bool present, const std::string& field);
  /// Refuses the numbers that only single systems have: epsilon, parameter, inertia_u, inertia_v.
  void refuse_other_numbers();

  /// Takes over `inertia` if it has `least` to `most` finite numbers.
  bool set_inertia(std::size_t least = 2, std::size_t most = Scene::max_dimension);
  /// Checks λ_i + λ_j > 0 for i ≠ j, which n = N needs.
  void check_inertia_sums();
  /// Checks λ_i > 0, which n < N needs.
  void check_inertia_positive();

  /// Refuses blocks that the system does not have, and imaginary parts unless `complex`.
  void check_block_names(bool complex = false);
  bool has_block(const std::string& name) { return given().initial.contains(name); }
  /// Returns the block if it is finite and has that shape. Else returns null and adds a violation,
  /// but not for a block that is absent and not required.
  const RowMatrix* block(const std::string& name, Eigen::Index rows, Eigen::Index cols,
                         bool required = true);

  void set_block(const std::string& name, Eigen::MatrixXd value);
  /// Sets a block with orthonormal rows, after repairing it within largest_repair.
  void set_frame(const std::string& name, const RowMatrix& Q);
  /// Sets a block to its skew part, which must be within Scene::skew_tolerance of it.
  void set_skew(const std::string& name, const RowMatrix& M);
  void set_body(const Body3& body);

 private:
  Scene scene_;
  double largest_repair_;
  const SystemInfo* system_ = nullptr;
  Violations violations_;
};

}  // namespace stiefel
