#include "server/calls/malformed.h"

#include <string>
#include <string_view>

#include "stiefel/v1/simulation.pb.h"

namespace stiefel::server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::Interceptor;
using grpc::experimental::InterceptorBatchMethods;
using grpc::experimental::ServerInterceptorFactoryInterface;
using grpc::experimental::ServerRpcInfo;

class Malformed final : public Interceptor {
 public:
  Malformed(const Log& log, const char* method) : log_(log), method_(method) {}

  void Intercept(InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS))
      look_at(*methods);
    methods->Proceed();
  }

 private:
  /// No handler of ours ends a call with UNIMPLEMENTED.
  void look_at(InterceptorBatchMethods& methods) {
    const grpc::Status status = methods.GetSendStatus();
    if (status.error_code() != grpc::UNIMPLEMENTED || !status.error_message().empty()) return;
    const std::string text = "the request is no message of the type that the method takes";
    methods.ModifySendStatus({grpc::INVALID_ARGUMENT, text});
    log_.line(Log::Level::warn, "rpc",
              {{"method", method_}, {"code", "INVALID_ARGUMENT"}, {"error", text}});
  }

  const Log& log_;
  const char* method_;
};

class Factory final : public ServerInterceptorFactoryInterface {
 public:
  explicit Factory(const Log& log) : log_(log) {}
  /// None for a method that there is not: that is UNIMPLEMENTED by right.
  Interceptor* CreateServerInterceptor(ServerRpcInfo* call) override {
    const std::string_view path = call->method();
    const std::string method(path.substr(path.rfind('/') + 1));
    if (service_->FindMethodByName(method) == nullptr) return nullptr;
    return new Malformed(log_, call->method());
  }

 private:
  const Log& log_;
  const google::protobuf::ServiceDescriptor* service_ =
      v1::DescribeRequest::descriptor()->file()->FindServiceByName("SimulationService");
};

}  // namespace

std::vector<std::unique_ptr<ServerInterceptorFactoryInterface>> report_malformed(const Log& log) {
  std::vector<std::unique_ptr<ServerInterceptorFactoryInterface>> one;
  one.push_back(std::make_unique<Factory>(log));
  return one;
}

}  // namespace stiefel::server
