#include "server/calls/gate.h"

#include "server/convert/errors.h"

namespace stiefel::server {
namespace {

/// Ends a call before it has begun. Deletes itself.
template <class Reactor>
class Ended final : public Reactor {
 public:
  explicit Ended(const grpc::Status& status) { this->Finish(status); }
  void OnDone() override { delete this; }
};

grpc::Status status_of(Refused refused) {
  return refused == Refused::token_missing ? errors::token_missing() : errors::token_unknown();
}

}  // namespace

template <class Reactor, class... Messages>
Reactor* Gate::pass(const char* name, Reactor* (server::Service::*call)(Context*, Messages...),
                    Context* context, Messages... messages) {
  grpc::Status status;
  try {
    const auto refused = callers_ ? callers_->admit(*context) : std::nullopt;
    if (refused) status = status_of(*refused);
  } catch (...) {
    status = errors::from_current_exception();
  }
  if (status.ok()) return (service_.*call)(context, messages...);
  CallLog(host_.log, *context, name, {}, host_.metrics.get()).finish(status);
  return new Ended<Reactor>(status);
}

grpc::ServerUnaryReactor* Gate::Describe(Context* context, const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) {
  return pass("Describe", &server::Service::Describe, context, request, response);
}

grpc::ServerUnaryReactor* Gate::CreateSession(Context* context,
                                              const v1::CreateSessionRequest* request,
                                              v1::CreateSessionResponse* response) {
  return pass("CreateSession", &server::Service::CreateSession, context, request, response);
}

grpc::ServerUnaryReactor* Gate::GetSession(Context* context, const v1::GetSessionRequest* request,
                                           v1::GetSessionResponse* response) {
  return pass("GetSession", &server::Service::GetSession, context, request, response);
}

grpc::ServerUnaryReactor* Gate::ListSessions(Context* context,
                                             const v1::ListSessionsRequest* request,
                                             v1::ListSessionsResponse* response) {
  return pass("ListSessions", &server::Service::ListSessions, context, request, response);
}

grpc::ServerUnaryReactor* Gate::DeleteSession(Context* context,
                                              const v1::DeleteSessionRequest* request,
                                              v1::DeleteSessionResponse* response) {
  return pass("DeleteSession", &server::Service::DeleteSession, context, request, response);
}

grpc::ServerUnaryReactor* Gate::Step(Context* context, const v1::StepRequest* request,
                                     v1::StepResponse* response) {
  return pass("Step", &server::Service::Step, context, request, response);
}

grpc::ServerBidiReactor<v1::DriveRequest, v1::DriveResponse>* Gate::Drive(Context* context) {
  return pass("Drive", &server::Service::Drive, context);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* Gate::Stream(Context* context,
                                                         const grpc::ByteBuffer* request) {
  return pass("Stream", &server::Service::Stream, context, request);
}

grpc::ServerWriteReactor<v1::SummarizeResponse>* Gate::Summarize(
    Context* context, const v1::SummarizeRequest* request) {
  return pass("Summarize", &server::Service::Summarize, context, request);
}

grpc::ServerUnaryReactor* Gate::Diagnose(Context* context, const v1::DiagnoseRequest* request,
                                         v1::DiagnoseResponse* response) {
  return pass("Diagnose", &server::Service::Diagnose, context, request, response);
}

grpc::ServerUnaryReactor* Gate::ForkSession(Context* context, const v1::ForkSessionRequest* request,
                                            v1::ForkSessionResponse* response) {
  return pass("ForkSession", &server::Service::ForkSession, context, request, response);
}

grpc::ServerWriteReactor<v1::ConvertResponse>* Gate::Convert(Context* context,
                                                             const v1::ConvertRequest* request) {
  return pass("Convert", &server::Service::Convert, context, request);
}

grpc::ServerWriteReactor<v1::ConnectResponse>* Gate::Connect(Context* context,
                                                             const v1::ConnectRequest* request) {
  return pass("Connect", &server::Service::Connect, context, request);
}

grpc::ServerWriteReactor<v1::MeasureTradeoffResponse>* Gate::MeasureTradeoff(
    Context* context, const v1::MeasureTradeoffRequest* request) {
  return pass("MeasureTradeoff", &server::Service::MeasureTradeoff, context, request);
}

}  // namespace stiefel::server
