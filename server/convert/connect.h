#pragma once

#include <grpcpp/support/status.h>

#include <stop_token>
#include <vector>

#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "stiefel/connect.h"
#include "stiefel/v1/connect.pb.h"

namespace stiefel::server {

/// What a Connect asks for, checked: its pairs are frames that a path may join.
struct ConnectTask {
  std::vector<TwoPointProblem> problems;
  int steps = 0;
  int samples = 0;
  bool checksum = false;
};
OrStatus<ConnectTask> read(const v1::ConnectRequest& request);

/// A Connect, answered pair by pair in messages of limited size.
class ConnectAnswer {
 public:
  explicit ConnectAnswer(ConnectTask task) : task_(std::move(task)) {}

  /// Writes the next message over `response`; the search for a geodesic stops when it is asked to,
  /// and the pair's outcome is then CANCELLED.
  grpc::Status next(const std::stop_token& stop, v1::ConnectResponse& response);
  bool done() const { return pair_ == task_.problems.size() && trajectory_.empty(); }

 private:
  grpc::Status join(const std::stop_token& stop, v1::ConnectResponse& response);

  const ConnectTask task_;
  std::size_t pair_ = 0;  ///< the next one to join
  Parts trajectory_;      ///< what is left of the one before
};

}  // namespace stiefel::server
