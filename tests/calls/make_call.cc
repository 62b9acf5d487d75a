#include "tests/calls/make_call.h"

#include <google/protobuf/text_format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace stiefel::test {
namespace {

using Stub = v1::SimulationService::Stub;
using Take = std::function<bool(const google::protobuf::Message&)>;

class Maker {
 public:
  Maker(Stub& stub, grpc::ClientContext& context, const Take& take)
      : stub_(stub), context_(context), take_(take) {}

  template <class Request, class Response>
  grpc::Status operator()(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                       Response*),
                          const Request& request) {
    Response response;
    const grpc::Status status = (stub_.*method)(&context_, request, &response);
    if (status.ok()) take_(response);
    return status;
  }

  template <class Request, class Response>
  grpc::Status operator()(std::unique_ptr<grpc::ClientReader<Response>> (Stub::*method)(
                              grpc::ClientContext*, const Request&),
                          const Request& request) {
    const auto reader = (stub_.*method)(&context_, request);
    Response response;
    while (reader->Read(&response)) {
      if (take_(response)) continue;
      context_.TryCancel();
      break;
    }
    return reader->Finish();
  }

  grpc::Status operator()(const Drive& drive) {
    const auto stream = stub_.Drive(&context_);
    v1::DriveResponse response;
    grpc::Status refused;
    for (const auto& request : drive.requests()) {
      if (!refused.ok() || !stream->Write(request) || !stream->Read(&response)) break;
      const auto& error = response.error();
      if (response.has_error())
        refused = {static_cast<grpc::StatusCode>(error.code()), error.message(),
                   error.SerializeAsString()};
      else
        take_(response);
    }
    stream->WritesDone();
    const grpc::Status status = stream->Finish();
    return refused.ok() ? status : refused;
  }

 private:
  Stub& stub_;
  grpc::ClientContext& context_;
  const Take& take_;
};

}  // namespace

Calls every_call() {
  std::ifstream file(EVERY_CALL);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Calls calls;
  if (!google::protobuf::TextFormat::ParseFromString(text, &calls))
    throw std::runtime_error(EVERY_CALL);
  return calls;
}

std::string name_of(const Call& call) {
  const auto* field =
      call.GetReflection()->GetOneofFieldDescriptor(call, Call::descriptor()->oneof_decl(0));
  return field == nullptr ? "" : field->name();
}

grpc::Status make(Stub& stub, grpc::ClientContext& context, const Call& call, const Take& take) {
  Maker made(stub, context, take);
  switch (call.request_case()) {
    case Call::kDescribe:
      return made(&Stub::Describe, call.describe());
    case Call::kCreateSession:
      return made(&Stub::CreateSession, call.create_session());
    case Call::kGetSession:
      return made(&Stub::GetSession, call.get_session());
    case Call::kListSessions:
      return made(&Stub::ListSessions, call.list_sessions());
    case Call::kDeleteSession:
      return made(&Stub::DeleteSession, call.delete_session());
    case Call::kStep:
      return made(&Stub::Step, call.step());
    case Call::kDrive:
      return made(call.drive());
    case Call::kStream:
      return made(&Stub::Stream, call.stream());
    case Call::kDiagnose:
      return made(&Stub::Diagnose, call.diagnose());
    case Call::kForkSession:
      return made(&Stub::ForkSession, call.fork_session());
    case Call::kConvert:
      return made(&Stub::Convert, call.convert());
    case Call::kConnect:
      return made(&Stub::Connect, call.connect());
    case Call::kConjugatePoints:
      return made(&Stub::ConjugatePoints, call.conjugate_points());
    case Call::kMeasureTradeoff:
      return made(&Stub::MeasureTradeoff, call.measure_tradeoff());
    case Call::kSummarize:
      return made(&Stub::Summarize, call.summarize());
    case Call::kLinearize:
      return made(&Stub::Linearize, call.linearize());
    case Call::kLyapunovSpectrum:
      return made(&Stub::LyapunovSpectrum, call.lyapunov_spectrum());
    case Call::REQUEST_NOT_SET:
      return {};
  }
  return {};
}

}  // namespace stiefel::test
