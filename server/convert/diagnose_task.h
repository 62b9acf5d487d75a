#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/sessions/cursor.h"
#include "stiefel/diagnosis.h"
#include "stiefel/v1/diagnosis.pb.h"

namespace stiefel::server {

/// A Diagnose request whose names and shapes are checked.
struct DiagnoseTask {
  /// A two-form and the tangent vectors on which it is evaluated.
  struct Form {
    std::string name;
    TangentVector first, second;
  };
  /// The two functions of a Dirac bracket.
  struct Bracket {
    PairFactors first, second;
  };

  std::vector<std::string> invariants;
  std::vector<Form> forms;
  std::vector<Bracket> brackets;
  std::optional<v1::SymplecticTest> symplectic;
  v1::ErrorEstimation estimate_error = v1::ERROR_ESTIMATION_UNSPECIFIED;
};

/// Throws INVALID_ARGUMENT, and Stopped (stiefel/stop.h) on a stop request of the surrounding
/// StopScope.
DiagnoseTask read(const Session& session, const v1::DiagnoseRequest& request);

/// Writes the answer at the step where the cursor ended.
void answer(const DiagnoseTask& task, const Session& session, const Cursor& cursor,
            const std::stop_token& stop, v1::DiagnoseResponse* response);

}  // namespace stiefel::server
