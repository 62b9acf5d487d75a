#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/exit_status.h"
#include "stiefel/v1/simulation.pb.h"

namespace stiefel::cli {

/// Returns how the run ended and what is known about its accuracy: {"outcome", "diagnosis"}, with
/// "message" and, where there is one, "largest_step" after a numerical stop. The diagnosis starts
/// with its summary. `choice`: the method that the server chose, which the report then includes;
/// or null.
nlohmann::ordered_json report(const v1::RunStatus& run_status,
                              const v1::DiagnoseResponse& diagnosis, const v1::Choice* choice);

/// Returns how a run ended: {"outcome"}, after a numerical stop with "message" and, where there is
/// one, "largest_step" and "member".
nlohmann::ordered_json ending(const v1::RunStatus& run_status);
/// Adds "estimated_error" if it was estimated, in the names of stiefel.v1.EstimatedError.
nlohmann::ordered_json ending(const v1::RunStatus& run_status,
                              const v1::DiagnoseResponse& diagnosis);
/// Prints a report to stdout as JSON and its summary to stderr or, where stdout is a terminal and
/// `json` is not set, the diagnosis as a table: a line for each invariant, and the summary.
void print_report(const nlohmann::ordered_json& report, const v1::DiagnoseResponse& diagnosis,
                  bool json = false);

/// Returns one sentence with the worst drift and the estimated error, two measures that do not
/// bound each other: "invariants kept to 2.1e-16; estimated error at t = 6000: attitude 1.6e-02
/// (1.2°), momentum 3.2e-03". In an ensemble it names the member of each: "invariants kept to
/// 2.1e-16 (energy of member 3); ...".
std::string summary(const v1::DiagnoseResponse& diagnosis);
/// Writes `summary` to stderr if stderr is a terminal.
void show_summary(const v1::DiagnoseResponse& diagnosis);

/// Returns ALWAYS for true, never (UNSPECIFIED) for false and IF_CHEAPER without a value.
v1::ErrorEstimation error_estimation(std::optional<bool> asked);

/// Returns the name without its prefix: "LEFT_DOMAIN" for OUTCOME_LEFT_DOMAIN.
std::string to_string(v1::Outcome outcome);
/// Returns "exact", "bounded" or "drifts".
std::string to_string(v1::Conservation conservation);

/// Returns the exit status for a run status, and prints to stderr why a run stopped early.
ExitStatus conclude(const v1::RunStatus& run_status, std::int64_t last_step);

/// Prints the server's warnings to stderr.
void print_warnings(const google::protobuf::RepeatedPtrField<std::string>& warnings);

/// Prints the server's warnings about the session's scene to stderr and, if stderr is a terminal,
/// the method that the server chose.
void print_remarks(const v1::Session& session);

using Rows = std::vector<std::vector<std::string>>;

/// Prints a table to stdout. Columns are as wide as their widest cell, with two blanks between
/// them.
void print_table(const Rows& rows, const std::string& indent = "");

}  // namespace stiefel::cli
