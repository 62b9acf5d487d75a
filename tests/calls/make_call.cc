#include "tests/calls/make_call.h"

#include <google/protobuf/text_format.h>
#include <grpcpp/generic/generic_stub.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::test {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MethodDescriptor;

/// Returns the field of the call that is set, or null.
const FieldDescriptor* field_of(const Call& call) {
  return call.GetReflection()->GetOneofFieldDescriptor(call, Call::descriptor()->oneof_decl(0));
}

/// Returns the RPC with the name of the field: ListSessions of list_sessions.
const MethodDescriptor& rpc_of(const FieldDescriptor& field) {
  std::string name = field.camelcase_name();
  name[0] = static_cast<char>(std::toupper(name[0]));
  const auto* service = v1::StepRequest::descriptor()->file()->pool()->FindServiceByName(
      "stiefel.v1.SimulationService");
  const auto* method = service == nullptr ? nullptr : service->FindMethodByName(name);
  if (method == nullptr) throw std::runtime_error("calls.proto: no RPC " + name);
  return *method;
}

/// Returns the messages to send: the request, or the requests of a stream.
std::vector<const Message*> requests_of(const Call& call, const FieldDescriptor& field) {
  const Message& request = call.GetReflection()->GetMessage(call, &field);
  const auto* stream = dynamic_cast<const Drive*>(&request);
  if (stream == nullptr) return {&request};
  std::vector<const Message*> all;
  for (const auto& one : stream->requests()) all.push_back(&one);
  return all;
}

/// A call of any RPC whose operations wait for one another.
class Exchange {
 public:
  Exchange(const std::shared_ptr<grpc::Channel>& channel, grpc::ClientContext& context,
           const MethodDescriptor& rpc)
      : stub_(channel),
        stream_(stub_.PrepareCall(&context, "/" + rpc.service()->full_name() + "/" + rpc.name(),
                                  &queue_)),
        reply_(google::protobuf::MessageFactory::generated_factory()
                   ->GetPrototype(rpc.output_type())
                   ->New()) {
    stream_->StartCall(this);
    done();
  }

  bool write(const Message& request) {
    const grpc::Slice bytes(request.SerializeAsString());
    stream_->Write(grpc::ByteBuffer(&bytes, 1), this);
    return done();
  }

  void writes_done() {
    stream_->WritesDone(this);
    done();
  }

  /// Returns the next reply, or null at the end.
  const Message* read() {
    grpc::ByteBuffer buffer;
    stream_->Read(&buffer, this);
    grpc::Slice bytes;
    if (!done() || !buffer.DumpToSingleSlice(&bytes).ok()) return nullptr;
    return reply_->ParseFromArray(bytes.begin(), static_cast<int>(bytes.size())) ? reply_.get()
                                                                                 : nullptr;
  }

  grpc::Status finish() {
    grpc::Status status;
    stream_->Finish(&status, this);
    done();
    return status;
  }

 private:
  bool done() {
    void* tag = nullptr;
    bool ok = false;
    return queue_.Next(&tag, &ok) && ok;
  }

  grpc::CompletionQueue queue_;
  grpc::GenericStub stub_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;
  std::unique_ptr<Message> reply_;
};

/// Returns the error that a reply of Drive holds.
grpc::Status error_in(const Message& reply) {
  const auto* drive = dynamic_cast<const v1::DriveResponse*>(&reply);
  if (drive == nullptr || !drive->has_error()) return {};
  const auto& error = drive->error();
  return {static_cast<grpc::StatusCode>(error.code()), error.message(), error.SerializeAsString()};
}

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
  const auto* field = field_of(call);
  return field == nullptr ? "" : field->name();
}

grpc::Status make(const std::shared_ptr<grpc::Channel>& channel, grpc::ClientContext& context,
                  const Call& call, const std::function<bool(const Message&)>& take) {
  const auto* field = field_of(call);
  if (field == nullptr) return {};
  const MethodDescriptor& rpc = rpc_of(*field);
  Exchange exchange(channel, context, rpc);
  grpc::Status refused;
  const auto taken = [&](const Message* reply) {
    if (reply == nullptr) return false;
    refused = error_in(*reply);
    if (refused.ok() && !take(*reply)) context.TryCancel();
    return refused.ok();
  };
  for (const Message* request : requests_of(call, *field))
    if (!exchange.write(*request) || (rpc.client_streaming() && !taken(exchange.read()))) break;
  exchange.writes_done();
  while (refused.ok() && taken(exchange.read())) {
  }
  const grpc::Status status = exchange.finish();
  return refused.ok() ? status : refused;
}

}  // namespace stiefel::test
