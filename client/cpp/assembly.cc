#include "client/cpp/assembly.h"

#include <cstdint>
#include <limits>
#include <string>

#include "stiefel/client/error.h"

namespace stiefel::client {
namespace {

std::uint64_t bytes_a_number(v1::DataType type) {
  switch (type) {
    case v1::DATA_TYPE_COMPLEX128:
      return 16;
    case v1::DATA_TYPE_FLOAT32:
      return 4;
    case v1::DATA_TYPE_FLOAT64:
    case v1::DATA_TYPE_INT64:
      return 8;
    default:
      throw CorruptReply("an array has the unknown data type " + std::to_string(type));
  }
}

/// Returns the size of the whole array in bytes; the largest std::uint64_t if that overflows.
std::uint64_t bytes(const v1::Tensor& tensor) {
  std::uint64_t product = bytes_a_number(tensor.data_type());
  for (const std::uint64_t extent : tensor.shape()) {
    if (__builtin_mul_overflow(product, extent, &product))
      return std::numeric_limits<std::uint64_t>::max();
  }
  return product;
}

[[noreturn]] void throw_incomplete(const v1::Field& array) {
  throw CorruptReply("a part of the array " + array.name() + " is missing");
}

}  // namespace

void check_complete(const v1::Field& array) {
  if (array.value().data().size() != bytes(array.value())) throw_incomplete(array);
}

void Assembly::take(Fields* arrays) {
  for (auto& array : *arrays) take(&array);
}

void Assembly::take(v1::Field* array) {
  if (array->whole_shape().empty()) {
    *arrays_.Add() = std::move(*array);
    return;
  }
  if (array->offset() == 0) {
    auto* begun = arrays_.Add();
    *begun->mutable_name() = array->name();
    *begun->mutable_value()->mutable_shape() = array->whole_shape();
    begun->mutable_value()->set_data_type(array->value().data_type());
    *begun->mutable_value()->mutable_data() = std::move(*array->mutable_value()->mutable_data());
    return;
  }
  if (arrays_.empty()) throw_incomplete(*array);
  auto& begun = arrays_[arrays_.size() - 1];
  std::string& data = *begun.mutable_value()->mutable_data();
  std::uint64_t begin = 0;
  if (begun.name() != array->name() ||
      __builtin_mul_overflow(array->offset(), bytes_a_number(array->value().data_type()), &begin) ||
      begin != data.size())
    throw_incomplete(*array);
  data += array->value().data();
}

Fields Assembly::finish() {
  Fields done;
  done.Swap(&arrays_);
  for (const auto& array : done) check_complete(array);
  return done;
}

}  // namespace stiefel::client
