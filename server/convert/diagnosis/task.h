#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "server/convert/resolve.h"
#include "server/sessions/cursor.h"
#include "stiefel/v1/diagnosis.pb.h"

namespace stiefel::server {

/// A Diagnose request whose names and shapes are checked.
class DiagnoseTask {
 public:
  /// Throws Stopped (stiefel/stop.h) on a stop request of the surrounding StopScope.
  static OrStatus<DiagnoseTask> read(const Session& session, const v1::DiagnoseRequest& request);
  DiagnoseTask(DiagnoseTask&&) noexcept;
  ~DiagnoseTask();

  /// Whether the answer may be long work without slices: because of what the request asks for, or
  /// because the search for the largest step follows steps that may take long.
  bool takes_long(const Session& session) const;

  /// Returns the predicted work of the answer without the steps, in instructions, from its matrix
  /// products.
  double work(const Session& session) const;

  /// Writes the answer at the step where the cursor ended. `memory`: the bytes that the call holds.
  grpc::Status answer(const Session& session, const Cursor& cursor, std::uint64_t memory,
                      const std::stop_token& stop, v1::DiagnoseResponse* response) const;

 private:
  struct Parts;
  explicit DiagnoseTask(std::shared_ptr<const Parts> parts);
  std::shared_ptr<const Parts> parts_;
};

}  // namespace stiefel::server
