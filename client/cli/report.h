#pragma once

#include <nlohmann/json.hpp>

#include "client/cli/exit_status.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// How the run ended and what is known about its accuracy: {"outcome", "diagnosis"}, and after a
/// numerical stop "largest_step" (where there is one) and "message".
nlohmann::ordered_json report(const v1::Ending& ending, const v1::DiagnoseResponse& diagnosis);

/// "OUTCOME_LEFT_DOMAIN" is "LEFT_DOMAIN" to people.
std::string to_string(v1::Outcome outcome);
/// "exact", "bounded" or "drifts".
std::string to_string(v1::Kept kept);

/// The exit status for this ending; what stopped the run goes to stderr.
ExitStatus conclude(const v1::Ending& ending, std::int64_t last_step);

/// Prints what the server finds doubtful about the session's scene to stderr.
void print_warnings(const v1::Session& session);

}  // namespace stiefel::cli
