#pragma once

#include <grpcpp/support/status.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "stiefel/connect.h"
#include "stiefel/conversion.h"
#include "stiefel/tradeoff.h"
#include "stiefel/v1/conjugate.pb.h"
#include "stiefel/v1/connect.pb.h"
#include "stiefel/v1/conversion.pb.h"
#include "stiefel/v1/tradeoff.pb.h"

namespace stiefel::server {

/// Returns a conversion's refusal as an error status.
grpc::Status refused(const ConversionRefusal& refusal);

/// Answers a Convert in messages of limited size.
class ConversionAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  ConversionAnswer(const v1::ConvertRequest& request, std::uint64_t memory)
      : request_(request), memory_(memory) {}

  /// Writes the next message over `response`; the first call converts.
  grpc::Status next(v1::ConvertResponse& response);
  bool done() const { return started_ && scene_arrays_.empty() && blocks_.empty(); }

 private:
  grpc::Status convert(v1::ConvertResponse& response);

  const v1::ConvertRequest& request_;
  const std::uint64_t memory_;
  bool started_ = false;
  Parts scene_arrays_, blocks_;
};

/// Answers a MeasureTradeoff in parts: the reference, the points, the front.
class TradeoffAnswer {
 public:
  /// `memory`: the bytes that the call holds.
  TradeoffAnswer(const v1::MeasureTradeoffRequest& request, std::uint64_t memory)
      : request_(request), memory_(memory) {}

  /// Writes the next part over `response`. The part is not valid if a stop was requested.
  grpc::Status next(const std::stop_token& stop, v1::MeasureTradeoffResponse& response);
  bool done() const { return done_; }

 private:
  grpc::Status start(const std::stop_token& stop, v1::TradeoffSetup* setup);
  void finish(v1::TradeoffFront* front);

  const v1::MeasureTradeoffRequest& request_;
  const std::uint64_t memory_;
  std::optional<Tradeoff> tradeoff_;
  bool done_ = false;
};

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
