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
#include "stiefel/v1/conjugate.pb.h"
#include "stiefel/v1/connect.pb.h"

namespace stiefel::server {

/// Returns the error for a refusal of a pair; nothing for a search that was stopped or did not
/// succeed.
std::optional<grpc::Status> refused(const ConnectRefusal& refusal, std::size_t pair = 0);

/// A checked Connect request: a path can join the frames of each pair.
struct ConnectTask {
  std::vector<TwoPointProblem> problems;
  int steps = 0;
  int samples = 0;
  bool with_scene = true;
};
OrStatus<ConnectTask> read(const v1::ConnectRequest& request);
/// Returns how many pairs are joined at a time, of searches that take so many bytes each.
std::size_t searches_at_once(const v1::ConnectRequest& request, std::uint64_t bytes_each);

/// Answers a Connect in messages of limited size. Joins some pairs at a time, on the threads of the
/// crew. A pair whose search takes more than a limit is joined again, without that limit, after all
/// others.
class ConnectAnswer {
 public:
  /// `memory`: the bytes that the call holds; `at_once`: how many searches that is enough for.
  ConnectAnswer(ConnectTask task, std::uint64_t memory, std::size_t at_once);

  /// Writes the next message over `response`. A stop request ends the search for a geodesic, with
  /// the outcome CANCELLED for the pair.
  grpc::Status next(const std::stop_token& stop, v1::ConnectResponse& response);
  bool done() const { return waiting_.empty() && slow_.empty() && joined_.empty(); }

 private:
  /// The answer of a pair, and what does not fit into its first message.
  struct Joined {
    std::size_t pair;
    grpc::Status status = {};
    bool deferred = false;
    bool begun = false;
    v1::ConnectResponse first = {};
    Parts velocity = {}, scene_arrays = {}, trajectory = {};
  };

  /// Joins the pairs that come next.
  void join_some(const std::stop_token& stop);
  /// Joins one pair with at most `most_work` operations.
  void join(const std::stop_token& stop, double most_work, Joined& joined) const;

  const ConnectTask task_;
  const std::uint64_t memory_;
  const std::size_t at_once_;
  std::deque<std::size_t> waiting_, slow_;
  std::deque<Joined> joined_;  ///< in the order of their messages
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
