#include "stiefel/client/samples.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <stdexcept>

namespace stiefel::client {
namespace {

template <class Scalar>
constexpr v1::DataType type_of = v1::DATA_TYPE_UNSPECIFIED;
template <>
constexpr v1::DataType type_of<double> = v1::DATA_TYPE_FLOAT64;
template <>
constexpr v1::DataType type_of<std::complex<double>> = v1::DATA_TYPE_COMPLEX128;
template <>
constexpr v1::DataType type_of<float> = v1::DATA_TYPE_FLOAT32;
template <>
constexpr v1::DataType type_of<std::int64_t> = v1::DATA_TYPE_INT64;

std::uint64_t bytes_a_number(v1::DataType type) {
  return type == v1::DATA_TYPE_COMPLEX128 ? 16 : type == v1::DATA_TYPE_FLOAT32 ? 4 : 8;
}

[[noreturn]] void throw_incomplete(const std::string& what) {
  throw Error({grpc::StatusCode::DATA_LOSS, "the reply is incomplete: " + what});
}

/// Throws Error if the tensor has other than the bytes of its shape.
void check_bytes(const v1::Tensor& tensor) {
  std::uint64_t bytes = bytes_a_number(tensor.data_type());
  bool overflows = false;
  for (const std::uint64_t extent : tensor.shape())
    overflows |= __builtin_mul_overflow(bytes, extent, &bytes);
  if (overflows || bytes != tensor.data().size())
    throw_incomplete("an array has " + std::to_string(tensor.data().size()) +
                     " bytes, other than its shape says");
}

std::uint64_t extent(const v1::Tensor& tensor, int from_last) {
  const int axis = tensor.shape_size() - 1 - from_last;
  return axis < 0 ? 1 : tensor.shape(axis);
}

/// Returns the product of the axes before rows and columns.
std::size_t matrices(const v1::Tensor& tensor) {
  const auto& shape = tensor.shape();
  return std::accumulate(shape.begin(), std::max(shape.begin(), shape.end() - 2), std::size_t{1},
                         std::multiplies<>());
}

}  // namespace

template <class Scalar>
MatrixView<Scalar> matrix(const v1::Tensor& tensor, std::size_t index) {
  if (tensor.data_type() != type_of<Scalar>)
    throw std::invalid_argument("the tensor has numbers of another type, " +
                                v1::DataType_Name(tensor.data_type()));
  check_bytes(tensor);
  if (index >= matrices(tensor))
    throw std::out_of_range("the tensor has no matrix " + std::to_string(index));
  const auto rows = static_cast<Eigen::Index>(extent(tensor, 1)),
             cols = static_cast<Eigen::Index>(extent(tensor, 0));
  const auto* numbers = reinterpret_cast<const Scalar*>(tensor.data().data());
  return {numbers + static_cast<Eigen::Index>(index) * rows * cols, rows, cols};
}
template MatrixView<double> matrix(const v1::Tensor&, std::size_t);
template MatrixView<std::complex<double>> matrix(const v1::Tensor&, std::size_t);
template MatrixView<float> matrix(const v1::Tensor&, std::size_t);
template MatrixView<std::int64_t> matrix(const v1::Tensor&, std::size_t);

std::vector<std::string_view> Sample::fields() const {
  std::vector<std::string_view> names;
  for (const auto& field : *fields_) names.push_back(field.name());
  return names;
}

const v1::Tensor& Sample::find(std::string_view name) const {
  const auto found = std::ranges::find(*fields_, name, &v1::Field::name);
  if (found == fields_->end())
    throw std::out_of_range("no field \"" + std::string(name) + "\" in this sample");
  return found->value();
}

std::size_t Sample::first(const v1::Tensor& tensor, std::size_t member) const {
  const std::size_t members = matrices(tensor) / samples_;
  if (member >= members)
    throw std::out_of_range("member " + std::to_string(member) + " of " + std::to_string(members));
  return index_ * members;
}

const v1::StreamResponse* Samples::next_batch() {
  while (v1::StreamResponse* reply = replies_.next()) {
    if (reply->has_checkpoint()) checkpoint_ = reply->checkpoint();
    if (reply->has_run_status()) run_status_ = reply->run_status();
    if (reply->steps().empty()) continue;
    for (const auto& field : reply->fields())
      if (reply->times_size() != reply->steps_size() || field.value().shape().empty() ||
          std::cmp_not_equal(field.value().shape(0), reply->steps_size()))
        throw_incomplete("the field " + field.name() + " has not as many samples as steps");
    return reply;
  }
  return nullptr;
}

}  // namespace stiefel::client
