// Calls of the service within one process, without a socket: every answer is numbers or an error of
// ours, never an internal one.
#include "tests/fuzz/calls.pb.h"

#include <grpcpp/grpcpp.h>

#include <chrono>

#include "server/server.h"
#include "stiefel/v1/error.pb.h"
#include "stiefel/v1/simulation.grpc.pb.h"
#include "tests/fuzz/small.h"
#include "tests/fuzz/target.h"

namespace stiefel::fuzz {
namespace {

using Stub = v1::SimulationService::Stub;

/// A refusal must name the fields at fault in its details, or its reason.
void require_typed(const grpc::Status& status) {
  using grpc::StatusCode;
  const auto code = status.error_code();
  if (code == StatusCode::OK || code == StatusCode::DEADLINE_EXCEEDED) return;
  require(code != StatusCode::INTERNAL && code != StatusCode::UNKNOWN &&
              code != StatusCode::UNIMPLEMENTED,
          "an error of the protocol: " + status.error_message());
  v1::Status details;
  require(details.ParseFromString(status.error_details()) && details.details_size() > 0,
          "an error has details: " + status.error_message());
  for (const auto& detail : details.details()) {
    v1::BadRequest bad;
    if (!detail.type_url().ends_with("BadRequest")) continue;
    require(bad.ParseFromString(detail.value()) && bad.field_violations_size() > 0,
            "a bad request has violations");
    for (const auto& violation : bad.field_violations())
      require(!violation.field().empty() && !violation.description().empty(),
              "a violation names field and rule");
  }
}

/// Limits that keep a case to milliseconds: few steps, and a deadline for calls without steps.
constexpr std::int64_t most_steps = 200;
constexpr auto deadline = std::chrono::milliseconds(100);

std::int64_t few(std::int64_t step) {
  return step > most_steps && step <= std::int64_t{1} << 53 ? step % most_steps : step;
}

class Program {
 public:
  Program()
      : server_({.threads = 1, .max_sessions = 4, .log_level = "off"}),
        stub_(v1::SimulationService::NewStub(server_.in_process_channel())) {}

  void run(Calls calls) {
    checkpoint_.clear();
    for (Call& call : *calls.mutable_calls()) make(call, calls.hand_on_checkpoints());
    forget();
  }

 private:
  /// A unary call.
  template <class Request, class Response>
  Response ask(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
               const Request& request) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    Response response;
    require_typed((*stub_.*method)(&context, request, &response));
    require_no_nan(response);
    return response;
  }

  /// At most `most` messages of a stream, which is then cancelled.
  template <class Response, class Reader>
  void read_some(grpc::ClientContext& context, Reader reader, int most) {
    Response response;
    for (int k = 0; k < most && reader->Read(&response); ++k) require_no_nan(response);
    context.TryCancel();
    const auto status = reader->Finish();
    if (status.error_code() != grpc::StatusCode::CANCELLED) require_typed(status);
  }

  void make(Call& call, bool hand_on);
  void drive(const v1::DriveRequest& request);
  /// Removes the sessions, so that a case does not depend on those before.
  void forget();

  server::Server server_;
  std::unique_ptr<Stub> stub_;
  std::string checkpoint_;
};

void Program::make(Call& call, bool hand_on) {
  switch (call.request_case()) {
    case Call::kDescribe:
      return void(ask(&Stub::Describe, call.describe()));
    case Call::kCreateSession: {
      auto& request = *call.mutable_create_session();
      if (!make_small(request.mutable_scene())) return;
      if (hand_on) request.set_checkpoint(checkpoint_);
      return void(ask(&Stub::CreateSession, request));
    }
    case Call::kGetSession:
      return void(ask(&Stub::GetSession, call.get_session()));
    case Call::kListSessions:
      return void(ask(&Stub::ListSessions, call.list_sessions()));
    case Call::kDeleteSession:
      return void(ask(&Stub::DeleteSession, call.delete_session()));
    case Call::kStep:
      call.mutable_step()->set_to(few(call.step().to()));
      checkpoint_ = ask(&Stub::Step, call.step()).checkpoint();
      return;
    case Call::kDrive:
      call.mutable_drive()->set_to(few(call.drive().to()));
      return drive(call.drive());
    case Call::kStream: {
      call.mutable_stream()->set_to(few(call.stream().to()));
      grpc::ClientContext context;
      return read_some<v1::StreamResponse>(context, stub_->Stream(&context, call.stream()), 4);
    }
    case Call::kDiagnose: {
      auto& request = *call.mutable_diagnose();
      request.set_to(few(request.to()));
      if (request.symplectic_test().pairs() > 8) request.mutable_symplectic_test()->set_pairs(1001);
      return void(ask(&Stub::Diagnose, request));
    }
    case Call::kForkSession:
      call.mutable_fork_session()->set_from_step(few(call.fork_session().from_step()));
      if (call.fork_session().method().substeps() > 4) return;
      return void(ask(&Stub::ForkSession, call.fork_session()));
    case Call::kConvert: {
      if (!make_small(call.mutable_convert()->mutable_scene())) return;
      grpc::ClientContext context;
      context.set_deadline(std::chrono::system_clock::now() + deadline);
      return read_some<v1::ConvertResponse>(context, stub_->Convert(&context, call.convert()), 2);
    }
    case Call::kConnect: {
      grpc::ClientContext context;
      context.set_deadline(std::chrono::system_clock::now() + deadline);
      return read_some<v1::ConnectResponse>(context, stub_->Connect(&context, call.connect()), 2);
    }
    case Call::kMeasureTradeoff: {
      auto& request = *call.mutable_measure_tradeoff();
      if (!make_small(request.mutable_scene())) return;
      grpc::ClientContext context;
      context.set_deadline(std::chrono::system_clock::now() + deadline);
      return read_some<v1::MeasureTradeoffResponse>(context,
                                                    stub_->MeasureTradeoff(&context, request), 2);
    }
    case Call::REQUEST_NOT_SET:
      return;
  }
}

void Program::drive(const v1::DriveRequest& request) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + deadline);
  const auto stream = stub_->Drive(&context);
  v1::DriveResponse response;
  for (int k = 0; k < 2 && stream->Write(request) && stream->Read(&response); ++k) {
    require_no_nan(response);
    if (!response.has_error()) continue;
    const auto& error = response.error();
    require_typed(
        {static_cast<grpc::StatusCode>(error.code()), error.message(), error.SerializeAsString()});
  }
  stream->WritesDone();
  require_typed(stream->Finish());
}

void Program::forget() {
  const auto sessions = ask(&Stub::ListSessions, {});
  for (const auto& session : sessions.sessions()) {
    v1::DeleteSessionRequest request;
    request.set_session_id(session.session_id());
    ask(&Stub::DeleteSession, request);
  }
}

}  // namespace

std::unique_ptr<google::protobuf::Message> input() { return std::make_unique<Calls>(); }

void run(const google::protobuf::Message& message) {
  static Program program;
  program.run(dynamic_cast<const Calls&>(message));
}

}  // namespace stiefel::fuzz
