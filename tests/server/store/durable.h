#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

#include "tests/server/harness.h"
#include "tests/support/folder.h"

/// Calls of servers with a store, and what they answer.
namespace stiefel::test {

inline server::Options with_store(const std::string& file) {
  server::Options options;
  options.threads = 2;
  options.log_level = "off";
  options.store = file;
  return options;
}

/// A scene for each number.
inline v1::Scene numbered(int number) {
  v1::Scene scene = wire_scene();
  scene.set_step(0.01 + 1e-6 * number);
  return scene;
}

/// Makes a call of the stub. Returns the reason of its error, or "".
template <class Request, class Response>
std::string refusal_of(Stub& stub,
                       grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                    Response*),
                       const Request& request, Response* response) {
  grpc::ClientContext context;
  const grpc::Status status = (stub.*method)(&context, request, response);
  v1::Status details;
  v1::ErrorInfo info;
  details.ParseFromString(status.error_details());
  if (details.details_size() > 0) info.ParseFromString(details.details(0).value());
  return status.ok() ? "" : info.reason();
}

// These return the reason of the error, or "".

inline std::string create(Stub& stub, const std::string& id, const v1::Scene& scene,
                          bool recreate = false) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  request.set_recreate(recreate);
  v1::CreateSessionResponse response;
  return refusal_of(stub, &Stub::CreateSession, request, &response);
}

/// As a handle does that has lost this session.
inline std::string recreate(Stub& stub, const std::string& id) {
  return create(stub, id, numbered(0), true);
}

inline std::string fork(Stub& stub, const std::string& id, const std::string& from,
                        std::int64_t step) {
  v1::ForkSessionRequest request;
  request.set_session_id(id);
  request.set_from_session_id(from);
  request.set_from_step(step);
  v1::ForkSessionResponse response;
  return refusal_of(stub, &Stub::ForkSession, request, &response);
}

inline std::string erase(Stub& stub, const std::string& id) {
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  v1::DeleteSessionResponse response;
  return refusal_of(stub, &Stub::DeleteSession, request, &response);
}

/// What GetSession answers, without what a restart may change.
inline std::optional<v1::Session> get(Stub& stub, const std::string& id, bool with_scene = false) {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.set_return_scene(with_scene);
  v1::GetSessionResponse response;
  if (!refusal_of(stub, &Stub::GetSession, request, &response).empty()) return std::nullopt;
  response.mutable_session()->clear_cached_steps();
  response.mutable_session()->clear_cursor();
  response.mutable_session()->clear_expire_time();
  return response.session();
}

/// A store's file that ends with the test.
class DurabilityTest : public ::testing::Test {
 protected:
  Folder folder_;
  const std::string file_ = folder_.file();
};

}  // namespace stiefel::test
