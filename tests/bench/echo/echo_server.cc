// The rival of the latency measurements: gRPC's callback API with nothing behind it. Prints
// "listening on ADDRESS" and stops when stdin ends.
#include <grpcpp/grpcpp.h>

#include <iostream>
#include <string>

#include "echo.grpc.pb.h"

namespace {

namespace v1 = stiefel::bench::v1;
using Context = grpc::CallbackServerContext;

class DriveReactor final : public grpc::ServerBidiReactor<v1::EchoRequest, v1::EchoResponse> {
 public:
  DriveReactor() { StartRead(&request_); }
  void OnReadDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::OK);
    response_.mutable_payload()->resize(request_.reply_bytes());
    StartWrite(&response_);
  }
  void OnWriteDone(bool ok) override {
    ok ? StartRead(&request_) : Finish(grpc::Status::CANCELLED);
  }
  void OnDone() override { delete this; }

 private:
  v1::EchoRequest request_;
  v1::EchoResponse response_;
};

class PourReactor final : public grpc::ServerWriteReactor<v1::EchoResponse> {
 public:
  explicit PourReactor(const v1::PourRequest& request) : left_(request.messages()) {
    message_.mutable_payload()->resize(request.message_bytes(), '\x3f');
    OnWriteDone(true);
  }
  void OnWriteDone(bool ok) override {
    if (!ok) return Finish(grpc::Status::CANCELLED);
    if (left_-- == 0) return Finish(grpc::Status::OK);
    StartWrite(&message_);
  }
  void OnDone() override { delete this; }

 private:
  v1::EchoResponse message_;
  std::uint64_t left_;
};

class Service final : public v1::EchoService::CallbackService {
  grpc::ServerUnaryReactor* Echo(Context* context, const v1::EchoRequest* request,
                                 v1::EchoResponse* response) override {
    response->mutable_payload()->resize(request->reply_bytes());
    auto* reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
  grpc::ServerBidiReactor<v1::EchoRequest, v1::EchoResponse>* Drive(Context*) override {
    return new DriveReactor;
  }
  grpc::ServerWriteReactor<v1::EchoResponse>* Pour(Context*,
                                                   const v1::PourRequest* request) override {
    return new PourReactor(*request);
  }
};

}  // namespace

int main() {
  Service service;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service);
  const auto server = builder.BuildAndStart();
  if (!server) return 1;
  std::cout << "listening on 127.0.0.1:" << port << std::endl;
  std::cin.get();
  server->Shutdown();
}
