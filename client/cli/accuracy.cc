// The sentence about accuracy in the report of a diagnosis.
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <numbers>

#include "client/cli/report.h"
#include "engine/numbers/to_text.h"

namespace stiefel::cli {
namespace {

std::string brief(double value) { return scientific_text(value, 2); }

std::string invariants_kept(const v1::DiagnoseResponse& diagnosis) {
  if (diagnosis.invariants().empty()) return "";
  const auto& worst = *std::ranges::max_element(
      diagnosis.invariants(), {}, [](const v1::Invariant& invariant) { return invariant.drift(); });
  std::string text = "invariants kept to " + brief(worst.drift());
  if (worst.has_member())
    text += " (" + worst.name() + " of member " + std::to_string(worst.member()) + ")";
  return text + "; ";
}

/// Returns the error of the attitude or the momentum. If the estimate does not give it, the error
/// is below twice that of the reference.
std::string error_of(const std::string& what, bool known, double error,
                     const v1::EstimatedError& estimate) {
  std::string text = what;
  text += known ? " " : " below ";
  return text + brief(known ? error : 2 * estimate.reference_error());
}

std::string estimated(const v1::EstimatedError& error) {
  std::string text;
  if (error.has_attitude()) text = error_of("attitude", true, error.attitude(), error);
  if (error.has_angle())
    text += " (" + stiefel::to_text(error.angle() * 180 / std::numbers::pi, 2) + "°)";
  if (!text.empty()) text += ", ";
  text += error_of("momentum", error.has_momentum(), error.momentum(), error);
  if (error.has_member()) text += ", of member " + std::to_string(error.member());
  return text;
}

}  // namespace

v1::ErrorEstimation error_estimation(std::optional<bool> asked) {
  if (!asked) return v1::ERROR_ESTIMATION_IF_CHEAPER;
  return *asked ? v1::ERROR_ESTIMATION_ALWAYS : v1::ERROR_ESTIMATION_UNSPECIFIED;
}

std::string summary(const v1::DiagnoseResponse& diagnosis) {
  const std::string kept = invariants_kept(diagnosis);
  const std::string at = "t = " + stiefel::to_text(diagnosis.time(), 6);
  if (!diagnosis.has_estimated_error()) return kept + "error at " + at + " not estimated";
  const auto& error = diagnosis.estimated_error();
  if (!error.missing().empty()) return kept + "error at " + at + " not known: " + error.missing();
  return kept + "estimated error at " + at + ": " + estimated(error);
}

void show_summary(const v1::DiagnoseResponse& diagnosis) {
  if (isatty(STDERR_FILENO)) std::cerr << "stiefel: " << summary(diagnosis) << '\n';
}

}  // namespace stiefel::cli
