#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::client {

static_assert(std::endian::native == std::endian::little, "tensors are little-endian on the wire");

/// The numbers of a tensor, row-major, where they lie in the message; real and imaginary part by
/// turns where it is complex. Empty where its numbers are float32.
std::span<const double> values(const v1::Tensor& tensor);
/// The numbers of a tensor of float32. Empty where its numbers are of another type.
std::span<const float> floats(const v1::Tensor& tensor);
/// A tensor as a matrix; all axes but the last are its rows.
v1::Matrix to_matrix(const v1::Tensor& tensor);

/// One field of one sample: rows × cols numbers, row by row; where they are complex each is its
/// real and its imaginary part. Of an ensemble those of its members, one after another.
struct FieldView {
  std::string_view name;
  std::size_t rows;
  std::size_t cols;
  std::span<const double> values;  ///< empty in a scene of scalar "float"
  std::span<const float> floats;   ///< empty in every other one
  bool complex = false;
  std::size_t members = 0;  ///< 0 unless it is of an ensemble

  /// The number of `values`, or of `floats` in single precision.
  std::size_t size() const { return values.size() + floats.size(); }
  double operator[](std::size_t i) const { return floats.empty() ? values[i] : floats[i]; }
};

/// The field of a single sample, as Step returns it. Throws std::out_of_range if there is none.
FieldView field(const v1::Sample& sample, std::string_view name);

/// One sample of a batch, seen where it lies in the message: valid as long as that message is.
class SampleView {
 public:
  SampleView(const v1::StreamResponse& batch, int index) : batch_(&batch), index_(index) {}

  std::int64_t step() const { return batch_->steps(index_); }
  double time() const { return batch_->times(index_); }
  int field_count() const { return batch_->fields_size(); }
  FieldView field(int i) const;
  /// Throws std::out_of_range if there is none.
  FieldView field(std::string_view name) const;

 private:
  const v1::StreamResponse* batch_;
  int index_;
};

}  // namespace stiefel::client
