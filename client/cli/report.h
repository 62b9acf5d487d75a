#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "client/cli/exit_status.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// How the run ended and what is known about its accuracy: {"outcome", "diagnosis"}, and after a
/// numerical stop "largest_step" (where there is one) and "message". The diagnosis starts with its
/// summary. `choice`: the method that the server chose, which is then part of the report; or null.
nlohmann::ordered_json report(const v1::RunStatus& run_status,
                              const v1::DiagnoseResponse& diagnosis, const v1::Choice* choice);

/// "invariants kept to 2.1e-16; estimated error at t = 6000: attitude 1.6e-02 (1.2°), momentum
/// 3.2e-03", two measures that do not bound each other.
std::string summary(const v1::DiagnoseResponse& diagnosis);
/// Writes `summary` to stderr if stderr is a terminal.
void show_summary(const v1::DiagnoseResponse& diagnosis);

/// Always, never, or when it takes less work than the run.
v1::ErrorEstimation error_estimation(std::optional<bool> asked);

/// "OUTCOME_LEFT_DOMAIN" is "LEFT_DOMAIN" to people.
std::string to_string(v1::Outcome outcome);
/// "exact", "bounded" or "drifts".
std::string to_string(v1::Conservation conservation);

/// The exit status for this run status; what stopped the run goes to stderr.
ExitStatus conclude(const v1::RunStatus& run_status, std::int64_t last_step);

/// Prints to stderr what the server finds doubtful about the session's scene, and if stderr is a
/// terminal the method that it chose.
void print_remarks(const v1::Session& session);

}  // namespace stiefel::cli
