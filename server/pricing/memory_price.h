#pragma once

#include <cstdint>
#include <vector>

#include "server/sessions/session.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel {
class Summary;
}

/// The bytes of memory that calls take beside the sessions and their simulations, predicted from
/// their requests.
namespace stiefel::server {

/// A reply with so many bytes of arrays: fields, message, message as bytes.
std::uint64_t reply_memory(std::uint64_t array_bytes);

/// A stream of the fields at its worst, when nobody reads it, without the state that it rests with;
/// with or without checkpoints.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            bool checkpoints);

/// A request, and what is read from it.
std::uint64_t reading_memory(const google::protobuf::Message& request);
/// The resolved scene.
std::uint64_t scene_memory(const v1::Scene& scene);
/// The first step of a new session and its reply. An ensemble's simulation is made by that step,
/// that of other scenes with the session.
std::uint64_t first_step_memory(const Scene& resolved, const v1::Scene& scene);
/// A choice of a method or a trade-off: one simulation at a time, of whatever method is largest,
/// and a reference of twice the precision.
std::uint64_t search_memory(const v1::Scene& scene);
/// MeasureTradeoff.
std::uint64_t tradeoff_memory(const v1::MeasureTradeoffRequest& request);
/// A fork: its scene, on the way from the old one to the new one.
std::uint64_t fork_memory(const Session& from);
/// Convert: the scene, the one in other variables, and what is left of it.
std::uint64_t conversion_memory(const v1::ConvertRequest& request);
/// Diagnose, beside the simulation.
std::uint64_t diagnosis_memory(const Session& session, const v1::DiagnoseRequest& request);
/// Summarize: its simulation and what it accumulates.
std::uint64_t summary_memory(const Session& session, const Summary& summary);
/// The largest search of a Connect.
std::uint64_t connect_memory(const v1::ConnectRequest& request);

}  // namespace stiefel::server
