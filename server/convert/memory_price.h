#pragma once

#include <cstdint>
#include <vector>

#include "server/sessions/sampling.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel {
class Summary;
}

/// Prices in bytes: the memory that calls take beside the sessions, their simulations, and the
/// requests as they arrived, which ReadRequest counts to the end of the call.
namespace stiefel::server {

/// The sizes on which the memory of a call depends, in bytes.
struct CallSizes {
  std::uint64_t request = 0;        ///< of what is read from the request
  std::uint64_t workspace = 0;      ///< of scenes, simulations and arrays that the call makes
  std::uint64_t reply = 0;          ///< of the arrays in its reply or in one of its messages
  const char* reply_of = "fields";  ///< the field of the request that makes a reply large
};

/// The most bytes of arrays in a reply. With its other fields it fits into protobuf's 2 GiB.
inline constexpr std::uint64_t max_reply_bytes =
    (std::uint64_t{2} << 30) - (std::uint64_t{1} << 20);

/// Returns the bytes of a call of these sizes. Those of its reply count three times: as fields, as
/// a message, and serialized. Throws StatusError, REPLY_TOO_LARGE.
std::uint64_t memory_price(const CallSizes& sizes);
/// Returns the most bytes of a Stream, those of one that nobody reads. The state at which it waits
/// is priced by its session.
std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            const Sampling::Range& range);

/// Returns the bytes of a scene in a reply: those of its arrays.
std::uint64_t scene_reply(const Session& session);

/// Returns the bytes of what is read from a message, as the message itself has them in memory.
std::uint64_t held_by(const google::protobuf::Message& message);

/// Return the workspaces of calls: resolving a scene; the first step of a new session, which makes
/// the simulation of an ensemble; the recommendation of a method for a scene, which makes one
/// simulation; the choice of a method, with one simulation at a time, of the method that needs
/// most, and references in twice the precision; a trade-off; a conversion; a Diagnose; a Summarize.
/// The scene of a message must have been read: the numbers that one names in vain have no price.
std::uint64_t scene_workspace(const v1::Scene& scene);
std::uint64_t first_step_workspace(const Scene& resolved);
std::uint64_t recommendation_workspace(SceneDescription scene);
std::uint64_t choice_workspace(const SceneDescription& scene);
std::uint64_t tradeoff_workspace(const SceneDescription& scene);
std::uint64_t conversion_workspace(const Scene& resolved);
std::uint64_t diagnosis_workspace(const Session& session);
std::uint64_t summary_workspace(const Session& session, const Summary& summary);

}  // namespace stiefel::server
