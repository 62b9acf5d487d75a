#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "stiefel/client/client.h"

namespace stiefel::cli {

/// How well a run keeps its invariants, how far it is from the exact motion, and how fast it turns.
struct RunData {
  v1::DiagnoseResponse last;  ///< at the last good step
  double speed = 0;           ///< the largest norm of Omega, 0 where there is none
  nlohmann::ordered_json
      drift;  ///< {"time", "families": [{"name", "conservation", "count", "drift"}]}
  nlohmann::ordered_json
      error;  ///< {"time", "attitude", "momentum"}; a bound where it is too small to tell
};

/// Diagnoses the run up to step `to` at some sixty steps. The error is estimated at a third of
/// them, where that is cheap.
RunData diagnose_run(const client::Session& session, std::int64_t to, v1::ErrorEstimation estimate);

/// Returns samples of the frame, if the scene has one, and of a rate, dense enough to be drawn,
/// from step 0 as far as their number allows: {"time", "fields"}. Arrays are base64. States between
/// steps are computed where the steps are too long; a discrete system has none.
nlohmann::ordered_json draw_samples(const client::Session& session, const v1::SystemInfo& system,
                                    const RunData& run, std::size_t member);

}  // namespace stiefel::cli
