// Calls of the service within one process, without a socket: every answer is numbers or an error of
// ours, never an internal one.
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <utility>

#include "server/server.h"
#include "stiefel/v1/error.pb.h"
#include "tests/calls/make_call.h"
#include "tests/fuzz/small.h"
#include "tests/fuzz/target.h"

namespace stiefel::fuzz {
namespace {

using test::Call;
using test::Calls;

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

/// Bounds the work of the call; returns whether it is to be made.
bool takes_little(Call& call) {
  switch (call.request_case()) {
    case Call::kCreateSession:
      return make_small(call.mutable_create_session()->mutable_scene());
    case Call::kConvert:
      return make_small(call.mutable_convert()->mutable_scene());
    case Call::kMeasureTradeoff:
      return make_small(call.mutable_measure_tradeoff()->mutable_scene());
    case Call::kStep:
      call.mutable_step()->set_to(few(call.step().to()));
      return true;
    case Call::kDrive: {
      auto& requests = *call.mutable_drive()->mutable_requests();
      for (auto& request : requests) request.set_to(few(request.to()));
      while (requests.size() > 4) requests.RemoveLast();
      return true;
    }
    case Call::kStream:
      call.mutable_stream()->set_to(few(call.stream().to()));
      return true;
    case Call::kSummarize:
      call.mutable_summarize()->set_to(few(call.summarize().to()));
      return true;
    case Call::kLinearize:
      call.mutable_linearize()->set_to(few(call.linearize().to()));
      return true;
    case Call::kLyapunovSpectrum:
      call.mutable_lyapunov_spectrum()->set_to(few(call.lyapunov_spectrum().to()));
      return true;
    case Call::kDiagnose: {
      auto& request = *call.mutable_diagnose();
      request.set_to(few(request.to()));
      if (request.symplectic_test().pairs() > 8) request.mutable_symplectic_test()->set_pairs(1001);
      return true;
    }
    case Call::kForkSession:
      call.mutable_fork_session()->set_from_step(few(call.fork_session().from_step()));
      return call.fork_session().method().substeps() <= 4;
    default:
      return true;
  }
}

class Program {
 public:
  Program()
      : server_({.threads = 1, .max_sessions = 4, .log_level = "off"}),
        stub_(v1::SimulationService::NewStub(server_.in_process_channel())) {}

  void run(Calls calls) {
    checkpoint_.clear();
    for (Call& call : *calls.mutable_calls()) {
      if (!takes_little(call)) continue;
      if (call.has_create_session() && calls.hand_on_checkpoints())
        call.mutable_create_session()->set_checkpoint(checkpoint_);
      make(call);
    }
    forget();
  }

 private:
  /// Takes at most four replies of a stream, which is then cancelled.
  void make(const Call& call) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    int replies = 0;
    const grpc::Status status =
        test::make(*stub_, context, call, [&](const google::protobuf::Message& reply) {
          require_no_nan(reply);
          if (const auto* step = dynamic_cast<const v1::StepResponse*>(&reply))
            checkpoint_ = step->checkpoint();
          if (const auto* list = dynamic_cast<const v1::ListSessionsResponse*>(&reply))
            sessions_ = list->sessions();
          return ++replies < 4;
        });
    if (status.error_code() != grpc::StatusCode::CANCELLED) require_typed(status);
  }

  /// Removes the sessions, so that a case does not depend on those before.
  void forget() {
    Call list, gone;
    list.mutable_list_sessions();
    make(list);
    for (const auto& session : std::exchange(sessions_, {})) {
      gone.mutable_delete_session()->set_session_id(session.session_id());
      make(gone);
    }
  }

  server::Server server_;
  std::unique_ptr<v1::SimulationService::Stub> stub_;
  std::string checkpoint_;
  google::protobuf::RepeatedPtrField<v1::Session> sessions_;
};

}  // namespace

std::unique_ptr<google::protobuf::Message> input() { return std::make_unique<Calls>(); }

void run(const google::protobuf::Message& message) {
  static Program program;
  program.run(dynamic_cast<const Calls&>(message));
}

}  // namespace stiefel::fuzz
