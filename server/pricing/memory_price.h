#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/sessions/session.h"

namespace stiefel {
class Summary;
}

/// Prices in bytes: the memory that calls take beside the sessions and their simulations, predicted
/// from the sizes of their requests.
namespace stiefel::server {

/// What the prices of a scene in a request depend on.
struct SceneSize {
  std::uint64_t bytes = 0;               ///< of the scene in the request
  std::optional<std::uint32_t> members;  ///< of an ensemble
  double rows = 3, cols = 3;             ///< of one member's largest block, at least 3 x 3
};

/// Returns the bytes of a reply with that many bytes of arrays: fields, message, serialized
/// message.
std::uint64_t reply_memory(std::uint64_t array_bytes);

/// Returns the bytes of a stream of the fields, with or without checkpoints, at its worst, when
/// nobody reads it; without the state with which it rests.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            bool checkpoints);

/// Returns the bytes of what is read from a request of that size, and of the call. The request
/// itself is counted from its arrival to the end of the call (ReadRequest).
std::uint64_t reading_memory(std::uint64_t request_bytes);
/// Returns the bytes of resolving a scene.
std::uint64_t scene_memory(const SceneSize& scene);
/// Returns the bytes of the first step of a new session and its reply, for a scene of
/// `given_bytes` in the request. That step makes the simulation of an ensemble; the session itself
/// makes that of other scenes.
std::uint64_t first_step_memory(const Scene& resolved, std::uint64_t given_bytes);
/// Returns the bytes of a choice of a method or of a trade-off: one simulation at a time, of the
/// method that needs most, and a reference in twice the precision.
std::uint64_t search_memory(const SceneSize& scene);
/// Returns the bytes of a MeasureTradeoff.
std::uint64_t tradeoff_memory(std::uint64_t request_bytes, const SceneSize& scene);
/// Returns the bytes of a fork: the scene in its steps from the old one to the new one.
std::uint64_t fork_memory(const Session& from);
/// Returns the bytes of a Convert: the scene, the converted scene, and the arrays left to send;
/// with those of the choice of a method if there is one.
std::uint64_t conversion_memory(std::uint64_t request_bytes, const SceneSize& scene,
                                bool chooses_method);
/// Returns the bytes of a Diagnose beside the session's simulation.
std::uint64_t diagnosis_memory(const Session& session, std::uint64_t request_bytes);
/// Returns the bytes of a Summarize: its simulation and its accumulators.
std::uint64_t summary_memory(const Session& session, const Summary& summary);
/// Returns the bytes of the search for a geodesic between two frames of shape n x N. `steps`: those
/// of a discrete geodesic, else 0. `samples`: of the trajectory, after the first.
std::uint64_t geodesic_memory(double n, double N, std::optional<std::uint32_t> restarts,
                              std::uint32_t steps, std::uint32_t samples);

}  // namespace stiefel::server
