#pragma once

#include <cstdint>

#include "server/sessions/session.h"
#include "stiefel/v1/simulation.pb.h"

/// Prices of requests in bytes: reads the numbers on which those of server/pricing depend.

/// Prices of requests in instructions: reads the numbers on which those of server/pricing depend.

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

/// Returns the instructions that finding the substeps of a recommended method takes, if the scene
/// names neither a method nor a tolerance; 0 where that is negligible.
double recommendation_work(const v1::Scene& scene);
/// Returns the most instructions that a MeasureTradeoff may take: its budget. A budget that is no
/// number, which is refused later, costs 0.
double tradeoff_work(const v1::MeasureTradeoffRequest& request);
/// Returns the most instructions that the searches of a Connect may take.
double connect_work(const v1::ConnectRequest& request);

/// The predicted instructions of what a Summarize reads, beside those of its steps.
struct ReadingWork {
  double each = 0;   ///< with a step at which it reads samples or looks for events
  double total = 0;  ///< of the call
};
ReadingWork reading_work(const Session& session, const v1::SummarizeRequest& request);

/// Returns the predicted instructions of making a session of the scene, and those of converting it.
double creation_work(const v1::Scene& scene);
double conversion_work(const v1::Scene& scene);

}  // namespace stiefel::server
