#include "client/cpp/late.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace stiefel::client {
namespace {

using namespace std::chrono_literals;

constexpr double work_per_second = 5e9;  // instructions of one core
constexpr auto stop = 60ms;              // in which a server ends a call whose time is over
constexpr auto answer = 250ms;           // for the server to say where the session stands

std::string short_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

std::string standing(const Connection& connection, const std::string& session_id, std::int64_t to) {
  std::this_thread::sleep_for(stop);
  v1::GetSessionRequest request;
  request.set_session_id(session_id);
  request.mutable_view()->set_scene(v1::SCENE_VIEW_NONE);
  try {
    const auto reply =
        connection.call(&v1::SimulationService::Stub::GetSession, request, answer, nullptr);
    const v1::Session& session = reply.session();
    const auto steps = static_cast<double>(std::max<std::int64_t>(0, to - session.cursor()));
    const double work = session.step_price().work() * steps;
    return "; the session stands at step " + std::to_string(session.cursor()) +
           ", from where the same call goes on. The steps from there take about " +
           short_text(work / work_per_second) + " s of one core (" + short_text(work) +
           " instructions)";
  } catch (const Error&) {
    return ", and the server does not answer";
  }
}

}  // namespace

Error with_standing(const Error& error, const Connection& connection, const std::string& session_id,
                    std::int64_t to) {
  if (error.code() != grpc::StatusCode::DEADLINE_EXCEEDED) return error;
  return Error(error.code(), std::string(error.what()) + ": step " + std::to_string(to) +
                                 " was not reached" + standing(connection, session_id, to));
}

}  // namespace stiefel::client
