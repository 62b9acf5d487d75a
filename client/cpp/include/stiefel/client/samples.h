#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::client {

static_assert(std::endian::native == std::endian::little, "tensors are little-endian on the wire");

/// Returns a view of the numbers of a tensor in the message, row-major; a complex number is its
/// real part followed by its imaginary part. Empty for a tensor of float32.
std::span<const double> values(const v1::Tensor& tensor);
/// Returns a view of the numbers of a tensor of float32; empty for other types.
std::span<const float> floats(const v1::Tensor& tensor);
/// Returns a tensor as a matrix, whose rows are all axes of the tensor but the last.
v1::Matrix to_matrix(const v1::Tensor& tensor);

/// A view of one field of one sample: rows × cols numbers, row by row; a complex number is its real
/// part followed by its imaginary part. In an ensemble, the numbers of all members, one member
/// after another.
struct FieldView {
  std::string_view name;
  std::size_t rows;
  std::size_t cols;
  std::span<const double> values;  ///< empty if the scene's scalar is "float"
  std::span<const float> floats;   ///< empty unless the scene's scalar is "float"
  bool complex = false;
  std::size_t members = 0;  ///< 0 for a single motion

  /// How many numbers `values` or, in single precision, `floats` has.
  std::size_t size() const { return values.size() + floats.size(); }
  double operator[](std::size_t i) const { return floats.empty() ? values[i] : floats[i]; }
};

/// Returns a field of a sample that Step returned. Throws std::out_of_range if the sample does not
/// have it.
FieldView field(const v1::Sample& sample, std::string_view name);

/// A view of one sample of a batch; valid as long as the message `batch`.
class SampleView {
 public:
  SampleView(const v1::StreamResponse& batch, int index) : batch_(&batch), index_(index) {}

  std::int64_t step() const { return batch_->steps(index_); }
  double time() const { return batch_->times(index_); }
  int field_count() const { return batch_->fields_size(); }
  FieldView field(int i) const;
  /// Throws std::out_of_range if the sample does not have the field.
  FieldView field(std::string_view name) const;

 private:
  const v1::StreamResponse* batch_;
  int index_;
};

}  // namespace stiefel::client
