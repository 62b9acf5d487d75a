#include "client/cpp/late.h"

#include <chrono>
#include <thread>

namespace stiefel::client {
namespace {

using namespace std::chrono_literals;

constexpr auto stop = 60ms;     // in which a server ends a call whose time is over
constexpr auto answer = 250ms;  // for the server to say where the session stands

std::string standing(const Connection& connection, const std::string& session_id) {
  std::this_thread::sleep_for(stop);
  v1::GetSessionRequest request;
  request.set_session_id(session_id);
  request.mutable_view()->set_scene(v1::SCENE_VIEW_NONE);
  try {
    const auto reply =
        connection.call(&v1::SimulationService::Stub::GetSession, request, answer, nullptr);
    return "; the session stands at step " + std::to_string(reply.session().cursor()) +
           ", from where the same call goes on";
  } catch (const Error&) {
    return ", and the server does not answer";
  }
}

}  // namespace

Error with_standing(const Error& error, const Connection& connection, const std::string& session_id,
                    std::int64_t to) {
  if (error.code() != grpc::StatusCode::DEADLINE_EXCEEDED) return error;
  return Error(error.code(), std::string(error.what()) + ": step " + std::to_string(to) +
                                 " was not reached" + standing(connection, session_id));
}

}  // namespace stiefel::client
