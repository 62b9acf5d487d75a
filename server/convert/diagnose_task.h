#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/convert/resolve.h"
#include "server/sessions/cursor.h"
#include "stiefel/diagnosis.h"
#include "stiefel/v1/diagnosis.pb.h"

namespace stiefel::server {

/// A Diagnose request whose names and shapes are checked.
class DiagnoseTask {
 public:
  /// Throws Stopped (stiefel/stop.h) on a stop request of the surrounding StopScope.
  static OrStatus<DiagnoseTask> read(const Session& session, const v1::DiagnoseRequest& request);

  /// Writes the answer at the step where the cursor ended.
  grpc::Status answer(const Session& session, const Cursor& cursor, const std::stop_token& stop,
                      v1::DiagnoseResponse* response) const;

 private:
  /// The most work of an error estimate, in instructions: about ten seconds.
  static constexpr double most_estimate_work = 5e10;

  /// A two-form and the tangent vectors on which it is evaluated.
  struct Form {
    std::string name;
    TangentVector first, second;
  };
  /// The two functions of a Dirac bracket.
  struct Bracket {
    PairFactors first, second;
  };
  DiagnoseTask() = default;
  bool estimates_error() const { return estimate_error_ != v1::ERROR_ESTIMATION_UNSPECIFIED; }
  void estimate(const Scene& scene, const Simulation& now, const std::stop_token& stop,
                v1::EstimatedError* out) const;

  std::vector<std::string> invariants_;
  std::vector<Form> forms_;
  std::vector<Bracket> brackets_;
  std::optional<v1::SymplecticTest> symplectic_;
  v1::ErrorEstimation estimate_error_ = v1::ERROR_ESTIMATION_UNSPECIFIED;
  std::size_t max_invariants_ = 0;
};

}  // namespace stiefel::server
