#pragma once

#include <functional>

#include "engine/stepping/invariant_list.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// Connects a scene with states that are dense matrices, blocks stacked by rows. The fields that a
/// system reports are data: a name, a shape and a function of the state for each.
class StackedObservables {
 public:
  using Point = Eigen::MatrixXd;
  using Value = std::function<void(const Point&, Eigen::Ref<RowMatrix>)>;

  /// Takes the state at step 0. Fields that `block` and `computed_block` add are the blocks; they
  /// must be added before the others.
  explicit StackedObservables(Point start) : start_(std::move(start)) {}

  /// Adds the block in the rows [first, first + rows) of the state.
  StackedObservables& block(std::string name, int first, int rows) {
    ++block_count_;
    return field(
        {std::move(name), rows, static_cast<int>(start_.cols())},
        [=](const Point& x, Eigen::Ref<RowMatrix> out) { out = x.middleRows(first, rows); });
  }
  StackedObservables& computed_block(Field field, Value value) {
    ++block_count_;
    return this->field(std::move(field), std::move(value));
  }
  StackedObservables& field(Field field, Value value) {
    fields_.push_back(std::move(field));
    values_.push_back(std::move(value));
    return *this;
  }

  std::function<void(const Point&, InvariantList&)> invariants;
  std::function<std::optional<double>(const Point&)> orthogonality = [](const Point&) {
    return std::optional<double>();
  };
  std::function<double(const Point&)> rate;

  const std::vector<Field>& fields() const { return fields_; }
  std::size_t block_count() const { return block_count_; }
  const Point& start(const Scene&) const { return start_; }
  void write(const Point& x, std::size_t index, std::span<double> out) const {
    const Field& field = fields_[index];
    const int values = field.complex ? 2 : 1;
    values_[index](x, Eigen::Map<RowMatrix>(out.data(), field.rows, values * field.cols));
  }

 private:
  Point start_;
  std::vector<Field> fields_;
  std::vector<Value> values_;
  std::size_t block_count_ = 0;
};

}  // namespace stiefel
