// Calls of the service within one process, without a socket: every answer is numbers or an error of
// ours, never an internal one.
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <utility>

#include "server/server.h"
#include "stiefel/v1/common.pb.h"
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

/// Bounds the steps and the scene of a request; returns whether it is to be sent.
bool takes_little(google::protobuf::Message& request) {
  const auto& reflection = *request.GetReflection();
  for (const char* name : {"to", "from_step"})
    if (const auto* field = request.GetDescriptor()->FindFieldByName(name);
        field != nullptr && field->cpp_type() == field->CPPTYPE_INT64)
      reflection.SetInt64(&request, field, few(reflection.GetInt64(request, field)));
  const auto* scene = request.GetDescriptor()->FindFieldByName("scene");
  return scene == nullptr || scene->message_type() != v1::Scene::descriptor() ||
         make_small(dynamic_cast<v1::Scene*>(reflection.MutableMessage(&request, scene)));
}

/// Bounds the work of the call; returns whether it is to be made.
bool takes_little(Call& call) {
  if (call.has_drive()) {
    auto& requests = *call.mutable_drive()->mutable_requests();
    while (requests.size() > 4) requests.RemoveLast();
    for (auto& request : requests) takes_little(request);
    return true;
  }
  if (call.has_diagnose() && call.diagnose().symplectic_test().pairs() > 8)
    call.mutable_diagnose()->mutable_symplectic_test()->set_pairs(1001);
  if (call.has_fork_session() && call.fork_session().method().substeps() > 4) return false;
  const auto* field =
      call.GetReflection()->GetOneofFieldDescriptor(call, Call::descriptor()->oneof_decl(0));
  return field == nullptr || takes_little(*call.GetReflection()->MutableMessage(&call, field));
}

class Program {
 public:
  Program()
      : server_({.threads = 1, .max_sessions = 4, .log_level = "off"}),
        channel_(server_.in_process_channel()) {}

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
        test::make(channel_, context, call, [&](const google::protobuf::Message& reply) {
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
  std::shared_ptr<grpc::Channel> channel_;
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
