#include "tests/fuzz/target.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "stiefel/v1/common.pb.h"

/// What the address sanitizer does not take for a leak. OpenSSL keeps data for each thread until
/// the thread ends, and gRPC's threads do not end before the program.
extern "C" const char* __lsan_default_suppressions() { return "leak:libcrypto"; }

namespace stiefel::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

void require_number(double x, const FieldDescriptor& field) {
  require(!std::isnan(x), field.full_name() + " is not a number");
}

void require_numbers(const v1::Tensor& tensor) {
  require(tensor.data().size() % sizeof(double) == 0, "a tensor of whole numbers");
  if (tensor.data_type() != v1::DATA_TYPE_FLOAT64) return;
  for (std::size_t at = 0; at < tensor.data().size(); at += sizeof(double)) {
    double x;
    std::memcpy(&x, tensor.data().data() + at, sizeof x);
    require(std::isfinite(x), "a field's number is not finite");
  }
}

}  // namespace

bool read(std::string_view bytes, Message* message) {
  if (bytes.starts_with('#'))
    return google::protobuf::TextFormat::ParseFromString(std::string(bytes), message);
  if (bytes.empty() || bytes[0] != '{')
    return message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  return google::protobuf::util::JsonStringToMessage(std::string(bytes), message).ok();
}

std::string to_json_text(const Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  require(status.ok(), "a message has a JSON form");
  return text + "\n";
}

std::string to_bytes(const Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream out(&stream);
  out.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&out);
  out.Trim();
  return bytes;
}

void require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "not so: %s\n", what.c_str());
  std::abort();
}

void require_no_nan(const Message& message) {
  if (const auto* tensor = dynamic_cast<const v1::Tensor*>(&message))
    return require_numbers(*tensor);
  const auto& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
        require_number(field->is_repeated() ? reflection.GetRepeatedDouble(message, field, i)
                                            : reflection.GetDouble(message, field),
                       *field);
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
        require_no_nan(field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                                            : reflection.GetMessage(message, field));
    }
  }
}

}  // namespace stiefel::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto message = stiefel::fuzz::input();
  if (stiefel::fuzz::read({reinterpret_cast<const char*>(data), size}, message.get()))
    stiefel::fuzz::run(*message);
  return 0;
}
