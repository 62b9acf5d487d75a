#pragma once

#include <functional>

#include "engine/motion/observables.h"
#include "stiefel/scene.h"

namespace stiefel {

/// Connects a scene with states that are dense matrices, blocks stacked by rows. The fields that a
/// system reports are data: a name, a shape and a function of the state for each.
class StackedObservables : public Observables {
 public:
  using Value = std::function<void(const Point&, Eigen::Ref<RowMatrix>)>;

  /// Takes the state at step 0. Fields that `block` and `computed_block` add are the blocks; they
  /// must be added before the others.
  explicit StackedObservables(Point start) : start_(std::move(start)) {}

  /// Adds the block in the rows [first, first + rows) of the state.
  StackedObservables& block(std::string name, int first, int rows);
  StackedObservables& computed_block(Field field, Value value);
  StackedObservables& field(Field field, Value value);

  std::function<void(const Point&, InvariantList&)> all_invariants;
  std::function<std::optional<double>(const Point&)> frame_defect;  ///< null: there is no frame
  std::function<double(const Point&)> speed;

  Point start(const Scene&) const override { return start_; }
  void write(const Point& x, std::size_t index, std::span<double> out) const override;
  void invariants(const Point& x, InvariantList& out) const override { all_invariants(x, out); }
  std::optional<double> orthogonality(const Point& x) const override;
  double rate(const Point& x) const override { return speed(x); }

 private:
  Point start_;
  std::vector<Value> values_;
};

/// Returns the start of a scene: its block `first` over `second`.
Eigen::MatrixXd stacked(const Scene& scene, const char* first, const char* second);

/// Whether a difference of matrices is only their rounding error: `norm` is its Frobenius norm,
/// `terms` that of the matrices, and the bound 16u·terms with u = 2⁻⁵³; where `terms` is 0, the
/// bound is 0. The momentum QᵀP − PᵀQ of a body at rest, for example, is computed as up to 2u‖P‖.
/// The drift of an invariant of such a state is divided by the value that the invariant has for a
/// momentum of size `terms`, so that it reads as a few u and not as 100 %.
inline bool is_rounding(double norm, double terms) { return norm <= 16 * 0x1p-53 * terms; }

}  // namespace stiefel
