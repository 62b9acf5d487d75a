#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <deque>
#include <stop_token>

#include "stiefel/v1/conjugate.pb.h"

namespace stiefel::server {

/// Answers a ConjugatePoints in messages of limited size.
class ConjugateAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  ConjugateAnswer(const v1::ConjugatePointsRequest& request, std::uint64_t memory)
      : request_(request), memory_(memory) {}

  /// Returns the bytes that a search takes.
  static std::uint64_t workspace(const v1::ConjugatePointsRequest& request);
  /// Returns the most instructions that a search takes.
  static double work();

  /// Writes the next message over `response`; the first call searches. A stop request ends the
  /// search with the outcome CANCELLED.
  grpc::Status next(const std::stop_token& stop, v1::ConjugatePointsResponse& response);
  bool done() const { return started_ && points_.empty(); }

 private:
  grpc::Status along_a_geodesic(const std::stop_token& stop, v1::ConjugatePointsResponse& response);
  grpc::Status of_the_radius(const std::stop_token& stop, v1::ConjugatePointsResponse& response);

  const v1::ConjugatePointsRequest& request_;
  const std::uint64_t memory_;
  bool started_ = false;
  std::deque<v1::ConjugatePoint> points_;  ///< not yet sent
};

}  // namespace stiefel::server
