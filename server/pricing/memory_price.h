#pragma once

#include <cstdint>
#include <vector>

#include "server/sessions/session.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel {
class Summary;
}

/// Prices in bytes: the memory that calls take beside the sessions and their simulations, predicted
/// from their requests.
namespace stiefel::server {

/// Returns the bytes of a reply with that many bytes of arrays: fields, message, serialized
/// message.
std::uint64_t reply_memory(std::uint64_t array_bytes);

/// Returns the bytes of a stream of the fields, with or without checkpoints, at its worst, when
/// nobody reads it; without the state with which it rests.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            bool checkpoints);

/// Returns the bytes of a request and of what is read from it.
std::uint64_t reading_memory(const google::protobuf::Message& request);
/// Returns the bytes of resolving a scene.
std::uint64_t scene_memory(const v1::Scene& scene);
/// Returns the bytes of the first step of a new session and its reply. That step makes the
/// simulation of an ensemble; the session itself makes that of other scenes.
std::uint64_t first_step_memory(const Scene& resolved, const v1::Scene& scene);
/// Returns the bytes of a choice of a method or of a trade-off: one simulation at a time, of the
/// method that needs most, and a reference in twice the precision.
std::uint64_t search_memory(const v1::Scene& scene);
/// Returns the bytes of a MeasureTradeoff.
std::uint64_t tradeoff_memory(const v1::MeasureTradeoffRequest& request);
/// Returns the bytes of a fork: the scene in its steps from the old one to the new one.
std::uint64_t fork_memory(const Session& from);
/// Returns the bytes of a Convert: the scene, the converted scene, and the arrays left to send.
std::uint64_t conversion_memory(const v1::ConvertRequest& request);
/// Returns the bytes of a Diagnose beside the session's simulation.
std::uint64_t diagnosis_memory(const Session& session, const v1::DiagnoseRequest& request);
/// Returns the bytes of a Summarize: its simulation and its accumulators.
std::uint64_t summary_memory(const Session& session, const Summary& summary);
/// Returns the bytes of the largest search of a Connect.
std::uint64_t connect_memory(const v1::ConnectRequest& request);

}  // namespace stiefel::server
