#include "stiefel/client/samples.h"

#include <stdexcept>
#include <string>

namespace stiefel::client {
namespace {

[[noreturn]] void throw_no_field(std::string_view name) {
  throw std::out_of_range("no field \"" + std::string(name) + "\" in this sample");
}

template <class Number>
std::span<const Number> numbers(const v1::Tensor& tensor) {
  const std::string& bytes = tensor.data();
  return {reinterpret_cast<const Number*>(bytes.data()), bytes.size() / sizeof(Number)};
}

template <class Number>
std::span<const Number> part(std::span<const Number> all, std::size_t index, std::size_t size) {
  return all.empty() ? all : all.subspan(index * size, size);
}

/// Returns a view of one sample of a field. The tensor's last two axes are rows and columns; before
/// them come the samples if `batched`, then the members of an ensemble.
FieldView view(const v1::Field& field, std::size_t sample, bool batched) {
  const auto& tensor = field.value();
  const auto& shape = tensor.shape();
  const bool ensemble = shape.size() == (batched ? 4 : 3);
  const std::size_t members = ensemble ? shape[shape.size() - 3] : 0;
  const std::size_t rows = shape.size() < 2 ? 1 : shape[shape.size() - 2];
  const std::size_t cols = shape.empty() ? 1 : shape[shape.size() - 1];
  const bool complex = tensor.data_type() == v1::DATA_TYPE_COMPLEX128;
  const std::size_t size = rows * cols * (complex ? 2 : 1) * (ensemble ? members : 1);
  return {field.name(),
          rows,
          cols,
          part(values(tensor), sample, size),
          part(floats(tensor), sample, size),
          complex,
          members};
}

}  // namespace

std::span<const double> values(const v1::Tensor& tensor) {
  if (tensor.data_type() == v1::DATA_TYPE_FLOAT32) return {};
  return numbers<double>(tensor);
}

std::span<const float> floats(const v1::Tensor& tensor) {
  if (tensor.data_type() != v1::DATA_TYPE_FLOAT32) return {};
  return numbers<float>(tensor);
}

v1::Matrix to_matrix(const v1::Tensor& tensor) {
  v1::Matrix matrix;
  std::uint64_t rows = 1;
  for (int axis = 0; axis + 1 < tensor.shape_size(); ++axis) rows *= tensor.shape(axis);
  matrix.set_rows(static_cast<std::uint32_t>(rows));
  matrix.set_cols(static_cast<std::uint32_t>(
      tensor.shape().empty() ? 1 : tensor.shape(tensor.shape_size() - 1)));
  const bool complex = tensor.data_type() == v1::DATA_TYPE_COMPLEX128;
  const std::size_t parts = complex ? 2 : 1;
  const auto all = values(tensor);
  for (std::size_t i = 0; i < all.size(); i += parts) matrix.add_values(all[i]);
  for (std::size_t i = 1; complex && i < all.size(); i += parts) matrix.add_imaginary(all[i]);
  for (const float number : floats(tensor)) matrix.add_values(number);
  return matrix;
}

FieldView field(const v1::Sample& sample, std::string_view name) {
  for (const auto& field : sample.fields()) {
    if (field.name() == name) return view(field, 0, false);
  }
  throw_no_field(name);
}

FieldView SampleView::field(int i) const {
  return view(batch_->fields(i), static_cast<std::size_t>(index_), true);
}

FieldView SampleView::field(std::string_view name) const {
  for (int i = 0; i < field_count(); ++i) {
    if (batch_->fields(i).name() == name) return field(i);
  }
  throw_no_field(name);
}

}  // namespace stiefel::client
