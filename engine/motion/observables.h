#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/motion/invariant_list.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// What can be read of a state, as data: the fields that the scene offers, each with a name, a
/// shape and a function of the state, and the functions below. A point is the state of a system as
/// a matrix of doubles: its blocks stacked by rows, or, for bodies in three dimensions, (q; m) or m
/// alone as a column.
class Observables {
 public:
  using Point = Eigen::MatrixXd;
  using Value = std::function<void(const Point&, Eigen::Ref<RowMatrix>)>;

  /// Takes the point at step 0. Fields that `block` and `computed_block` add are the system's
  /// blocks; they must be added before the others.
  explicit Observables(Point at_0) : start(std::move(at_0)) {}

  /// Adds the block in the rows [first, first + rows) of the state.
  Observables& block(std::string name, int first, int rows);
  Observables& computed_block(Field field, Value value);
  Observables& field(Field field, Value value);

  const std::vector<Field>& fields() const { return fields_; }
  std::size_t block_count() const { return block_count_; }
  void write(const Point& x, std::size_t index, std::span<double> out) const;

  Point start;
  std::function<void(const Point&, InvariantList&)> all_invariants;
  /// Returns max |QQᵀ − I|; nullopt where there is no frame.
  std::function<std::optional<double>(const Point&)> frame_defect = [](const Point&) {
    return std::nullopt;
  };
  std::function<double(const Point&)> speed;  ///< Simulation::rate
  /// Convert a point near the manifold from blocks stacked by rows, and to them.
  std::function<Point(const Eigen::MatrixXd& blocks)> from_blocks = std::identity();
  std::function<Eigen::MatrixXd(const Point&)> to_blocks = std::identity();

 private:
  std::vector<Field> fields_;
  std::size_t block_count_ = 0;
  std::vector<Value> values_;
};

using SharedObservables = std::shared_ptr<const Observables>;
inline SharedObservables shared(Observables observables) {
  return std::make_shared<const Observables>(std::move(observables));
}

/// Returns the start of a scene: its block `first` over `second`.
Eigen::MatrixXd stacked(const Scene& scene, const char* first, const char* second);

/// Whether a difference of matrices is only their rounding error: `norm` is its Frobenius norm,
/// `terms` that of the matrices, and the bound 16u·terms with u = 2⁻⁵³; where `terms` is 0, the
/// bound is 0. The momentum QᵀP − PᵀQ of a body at rest, for example, is computed as up to 2u‖P‖.
/// The drift of an invariant of such a state is divided by the value that the invariant has for a
/// momentum of size `terms`, so that it reads as a few u and not as 100 %.
inline bool is_rounding(double norm, double terms) { return norm <= 16 * 0x1p-53 * terms; }

}  // namespace stiefel
