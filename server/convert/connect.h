#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <stop_token>
#include <vector>

#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "stiefel/connect.h"
#include "stiefel/v1/connect.pb.h"

namespace stiefel::server {

/// A checked Connect request: a path can join the frames of each pair.
struct ConnectTask {
  std::vector<TwoPointProblem> problems;
  int steps = 0;
  int samples = 0;
};
OrStatus<ConnectTask> read(const v1::ConnectRequest& request);

/// Answers a Connect pair by pair, in messages of limited size.
class ConnectAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  ConnectAnswer(ConnectTask task, std::uint64_t memory) : task_(std::move(task)), memory_(memory) {}

  /// Writes the next message over `response`. A stop request ends the search for a geodesic, with
  /// the outcome CANCELLED for the pair.
  grpc::Status next(const std::stop_token& stop, v1::ConnectResponse& response);
  bool done() const { return pair_ == task_.problems.size() && trajectory_.empty(); }

 private:
  grpc::Status join(const std::stop_token& stop, v1::ConnectResponse& response);

  const ConnectTask task_;
  const std::uint64_t memory_;
  std::size_t pair_ = 0;  ///< the next pair to join
  Parts trajectory_;      ///< what is left to send of the pair before
};

}  // namespace stiefel::server
