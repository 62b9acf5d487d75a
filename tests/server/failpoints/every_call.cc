#include "tests/server/failpoints/every_call.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include "server/sessions/session.h"

namespace stiefel::test {
namespace {

using namespace std::chrono_literals;

/// Far beyond the work of any of these calls: a call that never ends fails the test.
constexpr auto deadline = 60s;

void limit(grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() + deadline);
}

std::string fields(const google::protobuf::RepeatedPtrField<v1::Field>& all) {
  std::string bytes;
  for (const auto& field : all) bytes += field.value().data();
  return bytes;
}

std::string samples(const v1::StreamResponse& message) {
  std::string bytes;
  for (const auto step : message.steps()) bytes += std::to_string(step) + ' ';
  return bytes + fields(message.fields());
}

/// Maps in the order of their keys.
std::string serialized(const google::protobuf::Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

template <class Response>
std::string nothing(const Response&) {
  return "";
}

}  // namespace

template <class Request, class Response>
Response EveryCall::unary(const std::string& name,
                          grpc::Status (Stub::*call)(grpc::ClientContext*, const Request&,
                                                     Response*),
                          const Request& request,
                          const std::function<std::string(const Response&)>& said) {
  grpc::ClientContext context;
  limit(context);
  Response response;
  const grpc::Status status = (stub_.*call)(&context, request, &response);
  hear(name, status.ok() ? said(response) : "", status);
  return response;
}

template <class Request, class Response>
void EveryCall::read(const std::string& name,
                     std::unique_ptr<grpc::ClientReader<Response>> (Stub::*call)(
                         grpc::ClientContext*, const Request&),
                     const Request& request,
                     const std::function<std::string(const Response&)>& said) {
  grpc::ClientContext context;
  limit(context);
  const auto reader = (stub_.*call)(&context, request);
  Response response;
  std::string all;
  while (reader->Read(&response)) all += said(response);
  hear(name, all, reader->Finish());
}

void EveryCall::create(const std::string& id, const Case& which, const std::string& checkpoint) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = wire_scene(which);
  request.set_checkpoint(checkpoint);
  unary<v1::CreateSessionRequest, v1::CreateSessionResponse>(
      "CreateSession " + id, &Stub::CreateSession, request,
      [](const auto& response) { return response.session().session_id(); });
}

std::string EveryCall::step(const std::string& id, std::int64_t to) {
  v1::StepRequest request;
  request.set_session_id(id);
  request.set_to(to);
  request.set_return_checkpoint(true);
  return unary<v1::StepRequest, v1::StepResponse>(
             "Step " + id + " " + std::to_string(to), &Stub::Step, request,
             [](const auto& response) { return bytes_of(response.sample()); })
      .checkpoint();
}

void EveryCall::stream(const std::string& id, std::int64_t to, std::int64_t every) {
  v1::StreamRequest request;
  request.set_session_id(id);
  request.set_to(to);
  request.set_every(every);
  request.set_checkpoint_every(to / 2);
  request.set_scene_arrays(true);
  read<v1::StreamRequest, v1::StreamResponse>("Stream " + id, &Stub::Stream, request, &samples);
}

/// An error that a reply holds ends the call here.
void EveryCall::drive(const std::string& id) {
  grpc::ClientContext context;
  limit(context);
  const auto calls = stub_.Drive(&context);
  std::string said;
  for (const std::int64_t to : {3, 40'000, 5}) {
    v1::DriveRequest request;
    request.set_session_id(id);
    request.set_to(to);
    v1::DriveResponse response;
    if (!calls->Write(request) || !calls->Read(&response)) break;
    if (response.has_error()) {
      calls->WritesDone();
      calls->Finish();
      const auto code = static_cast<grpc::StatusCode>(response.error().code());
      return hear("Drive", said,
                  {code, response.error().message(), response.error().SerializeAsString()});
    }
    said += bytes_of(response.step().sample());
  }
  calls->WritesDone();
  hear("Drive", said, calls->Finish());
}

void EveryCall::searches() {
  v1::ConvertRequest conversion;
  *conversion.mutable_scene() = wire_scene();
  conversion.set_to("symmetric_rigid_body");
  read<v1::ConvertRequest, v1::ConvertResponse>(
      "Convert", &Stub::Convert, conversion,
      [](const auto& response) { return serialized(response.scene()); });

  v1::ConnectRequest two_points;
  for (const double lambda : {1.0, 2.0, 3.0}) two_points.add_inertia(lambda);
  auto& pair = *two_points.add_pairs();
  for (auto* end : {pair.mutable_q_0(), pair.mutable_q_t()}) {
    end->set_rows(1);
    end->set_cols(3);
    for (int i = 0; i < 3; ++i) end->add_values(i == (end == &pair.q_t() ? 1 : 0));
  }
  two_points.set_time(1);
  read<v1::ConnectRequest, v1::ConnectResponse>(
      "Connect", &Stub::Connect, two_points,
      [](const auto& response) { return std::to_string(response.energy()); });

  v1::MeasureTradeoffRequest tradeoff;
  *tradeoff.mutable_scene() = wire_scene();
  tradeoff.set_horizon(0.05);
  tradeoff.set_budget(2e7);
  tradeoff.set_repeats(1);
  read<v1::MeasureTradeoffRequest, v1::MeasureTradeoffResponse>(
      "MeasureTradeoff", &Stub::MeasureTradeoff, tradeoff,
      [](const auto& response) { return response.has_point() ? "point " : "other "; });
}

std::vector<Heard> EveryCall::run() {
  heard_.clear();
  unary<v1::DescribeRequest, v1::DescribeResponse>(
      "Describe", &Stub::Describe, {},
      [](const auto& response) { return std::to_string(response.systems_size()); });
  const Case large{.method = "rk4", .dimension = 66};
  create("small", {});
  create("large", large);
  const std::string checkpoint = step("small", 700);
  step("small", 60'000);
  create("resumed", {}, checkpoint);
  step("resumed", 710);
  stream("small", 3000, 2);
  stream("large", 12, 1);
  step("large", 9);
  drive("small");

  v1::DiagnoseRequest diagnosis;
  diagnosis.set_session_id("small");
  diagnosis.set_to(50);
  unary<v1::DiagnoseRequest, v1::DiagnoseResponse>("Diagnose", &Stub::Diagnose, diagnosis,
                                                   [](const auto& response) {
                                                     std::string said;
                                                     for (const auto& one : response.invariants())
                                                       said += std::to_string(one.value()) + ' ';
                                                     return said;
                                                   });

  v1::ForkSessionRequest fork;
  fork.set_from_session_id("small");
  fork.set_from_step(30);
  fork.set_session_id("forked");
  unary<v1::ForkSessionRequest, v1::ForkSessionResponse>(
      "ForkSession", &Stub::ForkSession, fork,
      [](const auto& response) { return response.session().session_id(); });
  step("forked", 20);

  v1::SummarizeRequest summary;
  summary.set_session_id("small");
  summary.set_to(400);
  summary.set_every(10);
  for (int i = 0; i < 4; ++i) summary.add_times(0.995 * i);
  summary.set_checkpoint_every(200);
  read<v1::SummarizeRequest, v1::SummarizeResponse>(
      "Summarize", &Stub::Summarize, summary, [](const auto& response) {
        std::string said;
        for (const auto& one : response.states().fields()) said += one.value().data();
        return said;
      });
  searches();

  v1::GetSessionRequest get;
  get.set_session_id("small");
  unary<v1::GetSessionRequest, v1::GetSessionResponse>(
      "GetSession", &Stub::GetSession, get,
      [](const auto& response) { return response.session().session_id(); });
  unary<v1::ListSessionsRequest, v1::ListSessionsResponse>(
      "ListSessions", &Stub::ListSessions, {}, [](const auto& response) {
        std::string said;
        for (const auto& session : response.sessions()) said += session.session_id() + ' ';
        return said;
      });
  for (const char* id : {"small", "large", "resumed", "forked"}) {
    v1::DeleteSessionRequest gone;
    gone.set_session_id(id);
    unary<v1::DeleteSessionRequest, v1::DeleteSessionResponse>(std::string("DeleteSession ") + id,
                                                               &Stub::DeleteSession, gone,
                                                               &nothing<v1::DeleteSessionResponse>);
  }
  return std::move(heard_);
}

}  // namespace stiefel::test
