#pragma once

#include <grpc/grpc.h>
#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <memory>
#include <string_view>
#include <vector>

namespace stiefel::server {

/// Ends calls of the reflection service with RESOURCE_EXHAUSTED where `most` are open already: they
/// need no token, and each has a thread.
class ReflectionLimit final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  static constexpr int most = 16;

  /// Returns the interceptors of a server: a ReflectionLimit.
  static std::vector<std::unique_ptr<ServerInterceptorFactoryInterface>> interceptors() {
    std::vector<std::unique_ptr<ServerInterceptorFactoryInterface>> only;
    only.push_back(std::make_unique<ReflectionLimit>());
    return only;
  }

  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* call) override {
    const bool reflects = std::string_view(call->method()).starts_with("/grpc.reflection.");
    return reflects ? new OfCall(*this, *call) : nullptr;
  }

 private:
  class OfCall final : public grpc::experimental::Interceptor {
   public:
    OfCall(ReflectionLimit& limit, grpc::experimental::ServerRpcInfo& call)
        : limit_(limit), call_(call), refused_(limit.open_.fetch_add(1) >= most) {}
    ~OfCall() override { limit_.open_.fetch_sub(1); }

    void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
      using Point = grpc::experimental::InterceptionHookPoints;
      if (refused_ && methods->QueryInterceptionHookPoint(Point::POST_RECV_INITIAL_METADATA))
        grpc_call_cancel_with_status(call_.server_context()->c_call(),
                                     GRPC_STATUS_RESOURCE_EXHAUSTED,
                                     "16 calls of the reflection service are open", nullptr);
      methods->Proceed();
    }

   private:
    ReflectionLimit& limit_;
    grpc::experimental::ServerRpcInfo& call_;
    const bool refused_;
  };

  std::atomic<int> open_ = 0;
};

}  // namespace stiefel::server
