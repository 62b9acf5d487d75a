#include <algorithm>
#include <cstdint>
#include <cstring>

#include "server/convert/convert.h"

namespace stiefel::server {
namespace {

/// Whether no number's exponent, the bits of `mask`, consists of ones.
template <class Bits>
bool all_finite(const std::string& numbers, Bits mask) {
  bool finite = true;
  const std::size_t count = numbers.size() / sizeof(Bits);
  for (std::size_t i = 0; i < count; ++i) {
    Bits bits;
    std::memcpy(&bits, numbers.data() + i * sizeof bits, sizeof bits);
    finite &= (bits & mask) != mask;
  }
  return finite;
}

}  // namespace

bool is_finite(const v1::Field& field) {
  const v1::Tensor& tensor = field.value();
  if (tensor.data_type() == v1::DATA_TYPE_INT64) return true;
  if (tensor.data_type() == v1::DATA_TYPE_FLOAT32)
    return all_finite<std::uint32_t>(tensor.data(), 0x7f80'0000);
  return all_finite<std::uint64_t>(tensor.data(), 0x7ff0'0000'0000'0000);
}

bool is_finite(const google::protobuf::RepeatedPtrField<v1::Field>& fields) {
  return std::ranges::all_of(fields, [](const v1::Field& field) { return is_finite(field); });
}

void demand_finite(bool finite, v1::RunStatus* status) {
  if (finite || status->outcome() != v1::OUTCOME_REACHED) return;
  status->set_outcome(v1::OUTCOME_NOT_FINITE);
  status->set_message("a number of the reply is not finite");
}

}  // namespace stiefel::server
