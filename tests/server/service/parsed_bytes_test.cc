// The bound on the memory of a request before it is parsed, for what a caller can put into few
// bytes. What a message really takes is asked of protobuf, after parsing.
#include "server/calls/read_request.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::server {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::string varint(std::uint64_t x) {
  std::string out;
  for (; x > 127; x >>= 7) out += static_cast<char>((x & 127) | 128);
  return out + static_cast<char>(x);
}
std::string delimited(int field, const std::string& body) {
  return varint(static_cast<std::uint64_t>(field) << 3 | 2) + varint(body.size()) + body;
}
std::string times(int count, const std::string& what) {
  std::string out;
  for (int i = 0; i < count; ++i) out += what;
  return out;
}

/// What a message of the type can be filled with: each of its list and map fields, 3000 times, with
/// an empty and a short element, and the same one level deeper.
std::vector<std::string> fillings(const Descriptor& type, int depth = 0) {
  std::vector<std::string> out;
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor& field = *type.field(i);
    const int number = field.number();
    const std::uint64_t tag = static_cast<std::uint64_t>(number) << 3;
    if (const Descriptor* inner = field.message_type()) {
      const int count = field.is_repeated() ? 3000 : 1;
      out.push_back(times(count, delimited(number, "")));
      if (depth < 4)
        for (const std::string& within : fillings(*inner, depth + 1)) {
          // A map keeps one value for a key: the entries get different ones.
          std::string all;
          const int most = within.size() > 200 ? 1 : count;
          for (int k = 0; k < most; ++k)
            all +=
                delimited(number, (field.is_map() ? delimited(1, std::to_string(k)) : "") + within);
          out.push_back(all);
        }
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      const int count = field.is_repeated() ? 3000 : 1;
      for (const std::size_t size : {0, 15, 16, 40})
        out.push_back(times(count, delimited(number, std::string(size, 'x'))));
    } else if (field.is_repeated()) {
      if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
        out.push_back(times(3000, varint(tag | 1) + std::string(8, 'x')));
        out.push_back(times(3000, delimited(number, std::string(8, 'x'))));
        out.push_back(delimited(number, std::string(8 * 3000, 'x')));
      } else {
        out.push_back(times(3000, varint(tag) + '\1'));
        out.push_back(delimited(number, std::string(3000, '\1')));
      }
    } else if (field.cpp_type() != FieldDescriptor::CPPTYPE_DOUBLE) {
      out.push_back(varint(tag) + '\1');
    }
  }
  return out;
}

std::uint64_t taken(const std::string& bytes, const Descriptor& type) {
  google::protobuf::Arena arena;
  auto* message =
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type)->New(&arena);
  EXPECT_TRUE(message->ParseFromString(bytes)) << type.name();
  return std::max<std::uint64_t>(message->SpaceUsedLong(), arena.SpaceUsed());
}

TEST(ParsedBytes, BoundWhatEveryRequestTakes) {
  const auto* service = google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(
      v1::SimulationService::service_full_name());
  double largest = 0;
  for (int i = 0; i < service->method_count(); ++i) {
    const Descriptor& type = *service->method(i)->input_type();
    for (const std::string& bytes : fillings(type)) {
      const std::uint64_t bound = parsed_bytes(bytes, type).memory, size = taken(bytes, type);
      EXPECT_GE(bound, size) << type.name() << ", " << bytes.size() << " bytes that begin with "
                             << testing::PrintToString(bytes.substr(0, 20));
      if (bytes.size() > 5000)
        largest = std::max(largest, static_cast<double>(size) / static_cast<double>(bytes.size()));
    }
  }
  EXPECT_GT(largest, 20) << "the fillings are those that an attacker looks for";
}

TEST(ParsedBytes, BoundFieldsOfALaterVersion) {
  const Descriptor& type = *v1::StepRequest::descriptor();
  for (const std::string& bytes :
       {times(3000, varint(1000 << 3) + '\1'), times(3000, delimited(1000, "")),
        times(3000, varint(1000 << 3 | 3) + varint(1000 << 3 | 4)),
        delimited(1000, std::string(9000, 'x'))}) {
    const ParsedBytes found = parsed_bytes(bytes, type);
    EXPECT_GT(found.unknown, 0);
    EXPECT_GE(found.memory, taken(bytes, type)) << bytes.size();
  }
}

/// Numbers by which requests really are large cost little more than their bytes.
TEST(ParsedBytes, OfArraysAreTheirOwn) {
  v1::CreateSessionRequest request;
  auto& Q = (*request.mutable_scene()->mutable_initial())["Q"];
  for (int i = 0; i < 100'000; ++i) Q.add_values(i);
  (*request.mutable_scene()->mutable_initial_tensors())["M"].set_data(std::string(800'000, 'x'));
  const std::string bytes = request.SerializeAsString();
  EXPECT_LT(parsed_bytes(bytes, *request.descriptor()).memory,
            1.02 * static_cast<double>(bytes.size()));
}

TEST(ParsedBytes, OfWhatIsNoMessage) {
  for (const std::string& bytes :
       {std::string("\xff\xff\xff"), std::string(64, '\xff'), std::string("\x0a")})
    EXPECT_LT(parsed_bytes(bytes, *v1::StepRequest::descriptor()).memory, 10'000);
}

}  // namespace
}  // namespace stiefel::server
