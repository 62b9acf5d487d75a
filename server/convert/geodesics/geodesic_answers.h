#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "server/scheduling/memory_budget.h"
#include "stiefel/connect.h"
#include "stiefel/v1/geodesics.pb.h"

namespace stiefel::server {

/// Throws INVALID_ARGUMENT for a refusal of a pair's frames or fields, and Stopped
/// (stiefel/stop.h) for a search that was stopped; does nothing for one that did not succeed.
void throw_refused(const ConnectRefusal& refusal, std::size_t pair = 0);

/// A checked Connect request: a path can join the frames of each pair.
struct ConnectTask {
  std::vector<TwoPointProblem> problems;
  int steps = 0;
  int samples = 0;
  bool with_scene = true;
};
/// Throws INVALID_ARGUMENT.
ConnectTask read(const v1::ConnectRequest& request);
/// Returns how many pairs are joined at a time: one on each thread, and fewer where their searches,
/// of `bytes_each`, would take more than `most_bytes` together.
std::size_t searches_at_once(const v1::ConnectRequest& request, std::uint64_t bytes_each,
                             int threads, std::uint64_t most_bytes);
/// Returns the most bytes of answers that wait to be sent.
std::uint64_t waiting_answers_bytes(const v1::ConnectRequest& request);

/// Answers a Connect in messages of limited size. Joins pairs on the threads of the crew, each of
/// which begins the next pair when it has joined one. A pair whose search takes more than a limit
/// is joined again, without that limit, after all others. Thread-safe.
class ConnectAnswer {
 public:
  /// `at_once`: for how many searches the memory that the call holds is enough.
  ConnectAnswer(ConnectTask task, std::size_t at_once);

  /// Joins pairs until none is left, their answers have no room, or `pauses` returns true. Calls
  /// `answered` on the thread that joined a pair, once there is its answer. A stop request ends a
  /// search with the outcome CANCELLED for the pair. For one thread at a time.
  void join(const std::stop_token& stop, const std::function<bool()>& pauses,
            const std::function<void()>& answered);
  /// Whether pairs wait to be joined and their answers have room.
  bool can_join() const;

  /// Writes the next message over `response`; returns false if there is none now.
  bool next(v1::ConnectResponse& response);
  /// Whether all pairs are joined and all messages taken.
  bool done() const;

 private:
  /// A pair to be joined with at most so many operations.
  struct Search {
    std::size_t pair;
    double most_work;
  };
  /// The answer of a pair, and what does not fit into its first message.
  struct Joined {
    std::size_t pair;
    bool deferred = false;
    bool begun = false;
    v1::ConnectResponse first = {};
    Parts velocity = {}, scene_arrays = {}, trajectory = {};
  };

  bool has_room() const;
  /// Returns the search that comes next; nothing if `can_join` is false.
  std::optional<Search> begin_search();
  /// Returns whether the pair has its answer; if not, it is deferred.
  bool end_search(Joined joined);
  Joined joined(const std::stop_token& stop, const Search& search) const;

  const ConnectTask task_;
  const std::size_t at_once_;
  mutable std::mutex mutex_;
  // Guarded by mutex_.
  std::deque<std::size_t> waiting_, slow_;
  std::size_t searching_ = 0;  ///< number of pairs
  std::deque<Joined> joined_;  ///< in the order of their messages
};

/// Answers a ConjugatePoints in messages of limited size.
class ConjugateAnswer {
 public:
  /// `memory`: of the request; that of a search is taken once the request is read.
  ConjugateAnswer(const v1::ConjugatePointsRequest& request, MemoryLease memory)
      : request_(request), memory_(std::move(memory)) {}

  /// Writes the next message over `response`; the first call searches. A stop request ends the
  /// search with the outcome CANCELLED.
  void next(const std::stop_token& stop, v1::ConjugatePointsResponse& response);
  bool done() const { return started_ && points_.empty(); }

 private:
  /// Returns the bytes that a search takes.
  std::uint64_t workspace() const;
  void search(const std::stop_token& stop, v1::ConjugatePointsResponse& response);

  const v1::ConjugatePointsRequest& request_;
  MemoryLease memory_;
  bool started_ = false;
  std::deque<v1::ConjugatePoint> points_;  ///< not yet sent
};

}  // namespace stiefel::server
