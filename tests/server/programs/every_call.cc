#include "tests/server/programs/every_call.h"

#include <google/protobuf/text_format.h>

#include "tests/calls/make_call.h"

namespace stiefel::test {
namespace {

using namespace std::chrono_literals;
using google::protobuf::Message;

/// Far beyond the work of any of these calls: a call that never ends fails the test.
constexpr auto deadline = 60s;

/// Beside those of every RPC. A session "large" has samples of 68 KiB; "resumed" begins with the
/// checkpoint before it.
constexpr const char* more = R"(
  calls { create_session { session_id: "small" } }
  calls { create_session { session_id: "large" } }
  calls { step { session_id: "small" to: 60000 } }
  calls { step { session_id: "small" to: 700 return_checkpoint: true } }
  calls { create_session { session_id: "resumed" } }
  calls { step { session_id: "resumed" to: 710 } }
  calls { stream { session_id: "small" to: 3000 every: 2 checkpoint_every: 1500 scene_arrays: true } }
  calls { stream { session_id: "large" to: 12 checkpoint_every: 6 scene_arrays: true } }
  calls { step { session_id: "large" to: 9 return_checkpoint: true } }
  calls { drive { requests { session_id: "small" to: 3 } requests { to: 40000 } requests { to: 5 } } }
  calls { summarize { session_id: "small" to: 400 every: 10 times: [0, 0.995, 1.99, 2.985] checkpoint_every: 200 } }
  calls { convert { to: "symmetric_rigid_body" } }
  calls { delete_session { session_id: "small" } }
  calls { delete_session { session_id: "large" } }
  calls { delete_session { session_id: "resumed" } }
)";

Calls all_calls() {
  Calls all = every_call(), others;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(more, &others));
  for (Call& call : *others.mutable_calls()) {
    if (call.has_create_session())
      *call.mutable_create_session()->mutable_scene() =
          call.create_session().session_id() == "large"
              ? wire_scene({.method = "rk4", .dimension = 66})
              : wire_scene();
    if (call.has_convert()) *call.mutable_convert()->mutable_scene() = wire_scene();
  }
  all.MergeFrom(others);
  // What a run before could not delete would stand in the list of sessions.
  Calls with_deletions;
  for (const Call& call : all.calls())
    if (call.has_delete_session()) *with_deletions.add_calls() = call;
  with_deletions.MergeFrom(all);
  return with_deletions;
}

/// The bytes of every Field in a message.
std::string fields_in(const Message& message) {
  if (const auto* field = dynamic_cast<const v1::Field*>(&message)) return field->value().data();
  std::string bytes;
  const auto& reflection = *message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const auto* one : set) {
    if (one->message_type() == nullptr) continue;
    if (!one->is_repeated()) bytes += fields_in(reflection.GetMessage(message, one));
    for (int i = 0; one->is_repeated() && i < reflection.FieldSize(message, one); ++i)
      bytes += fields_in(reflection.GetRepeatedMessage(message, one, i));
  }
  return bytes;
}

/// What in a reply is the same every time, however the samples are divided into messages.
std::string said(const Message& reply) {
  std::string text;
  if (const auto* step = dynamic_cast<const v1::StepResponse*>(&reply))
    return bytes_of(step->sample());
  if (const auto* drive = dynamic_cast<const v1::DriveResponse*>(&reply))
    return bytes_of(drive->step().sample());
  if (const auto* stream = dynamic_cast<const v1::StreamResponse*>(&reply)) {
    for (const auto step : stream->steps()) text += std::to_string(step) + ' ';
    return text + fields_in(reply);
  }
  if (const auto* diagnosis = dynamic_cast<const v1::DiagnoseResponse*>(&reply))
    for (const auto& one : diagnosis->invariants()) text += std::to_string(one.value()) + ' ';
  if (const auto* geodesic = dynamic_cast<const v1::ConnectResponse*>(&reply))
    return std::to_string(geodesic->energy());
  if (const auto* growth = dynamic_cast<const v1::LyapunovSpectrumResponse*>(&reply))
    for (const double exponent : growth->exponents()) text += std::to_string(exponent) + ' ';
  if (const auto* part = dynamic_cast<const v1::MeasureTradeoffResponse*>(&reply))
    return part->has_point() ? "point " : "other ";
  if (const auto* list = dynamic_cast<const v1::ListSessionsResponse*>(&reply))
    for (const auto& session : list->sessions()) text += session.session_id() + ' ';
  if (const auto* catalogue = dynamic_cast<const v1::DescribeResponse*>(&reply))
    return std::to_string(catalogue->systems_size());
  return text + fields_in(reply);
}

}  // namespace

std::vector<Heard> call_all(const std::shared_ptr<grpc::Channel>& channel) {
  static const Calls all = all_calls();
  std::vector<Heard> heard;
  std::string checkpoint;
  for (Call call : all.calls()) {
    if (call.create_session().session_id() == "resumed")
      call.mutable_create_session()->set_checkpoint(checkpoint);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    Heard& one = heard.emplace_back(name_of(call), "", grpc::Status());
    one.status = make(channel, context, call, [&](const Message& reply) {
      one.said += said(reply);
      if (const auto* step = dynamic_cast<const v1::StepResponse*>(&reply))
        checkpoint = step->checkpoint();
      return true;
    });
  }
  return heard;
}

}  // namespace stiefel::test
