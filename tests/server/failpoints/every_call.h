#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/harness.h"

namespace stiefel::test {

/// What a caller gets of one call: the samples and numbers, as text or bytes, and the end.
struct Heard {
  std::string call;
  std::string said;
  grpc::Status status;
};

/// Every RPC once or more, on sessions that it creates and deletes; the same calls every time.
class EveryCall {
 public:
  explicit EveryCall(Stub& stub) : stub_(stub) {}

  std::vector<Heard> run();

 private:
  template <class Request, class Response>
  Response unary(const std::string& name,
                 grpc::Status (Stub::*call)(grpc::ClientContext*, const Request&, Response*),
                 const Request& request, const std::function<std::string(const Response&)>& said);
  template <class Request, class Response>
  void read(const std::string& name,
            std::unique_ptr<grpc::ClientReader<Response>> (Stub::*call)(grpc::ClientContext*,
                                                                        const Request&),
            const Request& request, const std::function<std::string(const Response&)>& said);
  void create(const std::string& id, const Case& which, const std::string& checkpoint = "");
  std::string step(const std::string& id, std::int64_t to);
  void stream(const std::string& id, std::int64_t to, std::int64_t every);
  void drive(const std::string& id);
  void searches();
  void hear(std::string call, std::string said, const grpc::Status& status) {
    heard_.push_back({std::move(call), std::move(said), status});
  }

  Stub& stub_;
  std::vector<Heard> heard_;
};

}  // namespace stiefel::test
