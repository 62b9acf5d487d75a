#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/sessions/server_session.h"
#include "stiefel/v1/simulation.pb.h"

/// Prices in instructions, predicted from requests before they run.
namespace stiefel::server {

/// Returns the instructions that finding the substeps of a recommended method takes, if the scene
/// names neither a method nor a tolerance; 0 where that is negligible.
double recommendation_work(const v1::Scene& scene);
/// Returns the predicted instructions of making a session: of resolving its scene and of one
/// simulation a member.
double creation_work(const v1::Scene& scene);
/// Returns the most instructions that a conversion takes.
double conversion_work(const v1::ConvertRequest& request);
/// Returns the most instructions that a fork takes, with its conversion if it has one.
double fork_work(const Session& from, const v1::ForkSessionRequest& request);
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

/// What the price of a Diagnose depends on, beside its session.
struct DiagnosisSize {
  bool manakov = false;          ///< whether the invariants include the coefficients of Manakov
  bool singular_values = false;  ///< whether they include those of complex blocks
  std::size_t forms = 0;
  std::vector<std::size_t> factors;  ///< of each Dirac bracket, of both of its functions
  std::uint32_t pairs = 0;           ///< of tangent vectors, of the symplectic test
  double estimate_work = 0;          ///< the most that an estimate of the error may take
};
/// Returns the predicted instructions of a Diagnose without its steps, from its matrix products.
double diagnosis_work(const Session& session, const DiagnosisSize& size);

}  // namespace stiefel::server
