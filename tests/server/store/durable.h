#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

#include "tests/server/harness.h"
#include "tests/server/store/folder.h"

/// Calls of servers with a store, and what they answer.
namespace stiefel::test {

inline server::Options with_store(const std::string& file, std::uint64_t limit = 0,
                                  const char* vfs = nullptr) {
  server::Options options;
  options.threads = 2;
  options.log_level = "off";
  options.store = {file, limit, vfs};
  return options;
}

/// A scene for each number.
inline v1::Scene numbered(int number) {
  v1::Scene scene = wire_scene();
  scene.set_step(0.01 + 1e-6 * number);
  return scene;
}

/// The call's end; the reason of the store's errors.
struct End {
  grpc::Status status;
  bool ok() const { return status.ok(); }
  std::string reason() const {
    v1::Status details;
    v1::ErrorInfo info;
    details.ParseFromString(status.error_details());
    if (details.details_size() > 0) info.ParseFromString(details.details(0).value());
    return info.reason();
  }
};

inline End create(Stub& stub, const std::string& id, const v1::Scene& scene) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  return {stub.CreateSession(&context, request, &response)};
}

inline End fork(Stub& stub, const std::string& id, const std::string& from, std::int64_t step) {
  v1::ForkSessionRequest request;
  request.set_session_id(id);
  request.set_from_session_id(from);
  request.set_from_step(step);
  grpc::ClientContext context;
  v1::ForkSessionResponse response;
  return {stub.ForkSession(&context, request, &response)};
}

inline End erase(Stub& stub, const std::string& id) {
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  grpc::ClientContext context;
  v1::DeleteSessionResponse response;
  return {stub.DeleteSession(&context, request, &response)};
}

/// What GetSession answers, without what a restart may change.
inline std::optional<v1::Session> get(Stub& stub, const std::string& id, v1::SceneView view) {
  v1::GetSessionRequest request;
  request.set_session_id(id);
  request.mutable_view()->set_scene(view);
  grpc::ClientContext context;
  v1::GetSessionResponse response;
  if (!stub.GetSession(&context, request, &response).ok()) return std::nullopt;
  response.mutable_session()->clear_cached_steps();
  response.mutable_session()->clear_cursor();
  response.mutable_session()->clear_expire_time();
  return response.session();
}

/// The reason why a handle that has lost this session may not create it again; OK if it did.
inline std::string recreate(Stub& stub, const std::string& id, const v1::Scene& scene) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = scene;
  request.set_recreate(true);
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  const End end{stub.CreateSession(&context, request, &response)};
  return end.ok() ? "OK" : end.reason();
}

/// A store's file that ends with the test.
class DurabilityTest : public ::testing::Test {
 protected:
  Folder folder_;
  const std::string file_ = folder_.file();
};

}  // namespace stiefel::test
