#include "server/convert/convert.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace stiefel::server {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

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

/// Whether no number of a field that is set is NaN.
bool field_is_finite(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    if (!field.is_repeated()) return !std::isnan(reflection.GetDouble(message, &field));
    for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
      if (std::isnan(reflection.GetRepeatedDouble(message, &field, i))) return false;
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    if (!field.is_repeated()) return is_finite(reflection.GetMessage(message, &field));
    for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
      if (!is_finite(reflection.GetRepeatedMessage(message, &field, i))) return false;
  }
  return true;
}

}  // namespace

bool is_finite(const v1::Tensor& tensor) {
  switch (tensor.data_type()) {
    case v1::DATA_TYPE_FLOAT32:
      return all_finite<std::uint32_t>(tensor.data(), 0x7f80'0000);
    case v1::DATA_TYPE_FLOAT64:
    case v1::DATA_TYPE_COMPLEX128:
      return all_finite<std::uint64_t>(tensor.data(), 0x7ff0'0000'0000'0000);
    default:
      return true;
  }
}

bool is_finite(const google::protobuf::RepeatedPtrField<v1::Field>& fields) {
  for (const v1::Field& field : fields)
    if (!is_finite(field.value())) return false;
  return true;
}

bool is_finite(const Message& message) {
  if (const auto* tensor = dynamic_cast<const v1::Tensor*>(&message)) return is_finite(*tensor);
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields)
    if (!field_is_finite(message, *field)) return false;
  return true;
}

void demand_finite(bool finite, v1::RunStatus* status) {
  if (finite || status->outcome() != v1::OUTCOME_REACHED) return;
  status->set_outcome(v1::OUTCOME_NOT_FINITE);
  status->set_message("a number of the reply is not finite");
}

}  // namespace stiefel::server
