#include "engine/motion/observables.h"

namespace stiefel {

Observables& Observables::block(std::string name, int first, int rows) {
  return computed_block(
      {std::move(name), rows, static_cast<int>(start.cols())},
      [=](const Point& x, Eigen::Ref<RowMatrix> out) { out = x.middleRows(first, rows); });
}

Observables& Observables::computed_block(Field field, Value value) {
  ++block_count_;
  return this->field(std::move(field), std::move(value));
}

Observables& Observables::field(Field field, Value value) {
  fields_.push_back(std::move(field));
  values_.push_back(std::move(value));
  return *this;
}

void Observables::write(const Point& x, std::size_t index, std::span<double> out) const {
  const Field& field = fields_[index];
  const int values = field.complex ? 2 : 1;
  values_[index](x, Eigen::Map<RowMatrix>(out.data(), field.rows, values * field.cols));
}

Eigen::MatrixXd stacked(const Scene& scene, const char* first, const char* second) {
  const Eigen::MatrixXd &a = scene.block(first), &b = scene.block(second);
  Eigen::MatrixXd x(a.rows() + b.rows(), a.cols());
  x << a, b;
  return x;
}

}  // namespace stiefel
