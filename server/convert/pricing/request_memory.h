#pragma once

#include <cstdint>

#include "server/sessions/session.h"
#include "stiefel/v1/simulation.pb.h"

/// Prices of requests in bytes: reads the numbers on which those of server/pricing depend.
namespace stiefel::server {

/// Returns the bytes of what is read from the request, and of the call.
std::uint64_t reading_memory(const google::protobuf::Message& request);
/// Returns the bytes of resolving a scene.
std::uint64_t scene_memory(const v1::Scene& scene);
/// Returns the bytes of the first step of a new session, and of its reply.
std::uint64_t first_step_memory(const Scene& resolved, const v1::Scene& scene);
/// Returns the bytes of the choice of a method for a scene.
std::uint64_t search_memory(const v1::Scene& scene);
std::uint64_t tradeoff_memory(const v1::MeasureTradeoffRequest& request);
std::uint64_t conversion_memory(const v1::ConvertRequest& request);
/// Returns the bytes of a Diagnose beside the session's simulation.
std::uint64_t diagnosis_memory(const Session& session, const v1::DiagnoseRequest& request);
/// Returns the bytes of the request and of the largest search of a Connect.
std::uint64_t connect_memory(const v1::ConnectRequest& request);

}  // namespace stiefel::server
