#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

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
/// Returns the most bytes of answers that wait to be sent, and of the one that is sent. Throws
/// StatusError, REPLY_TOO_LARGE.
std::uint64_t waiting_answers_bytes(const v1::ConnectRequest& request);

/// Answers a Connect, each pair by a message. Joins pairs on the threads of the crew, each of
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
  /// The answer of a pair.
  struct Joined {
    std::size_t pair;
    bool deferred = false;
    v1::ConnectResponse response = {};
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

/// Answers a ConjugatePoints. `memory` has that of the request; that of the search and of the reply
/// is taken once the request is read. A stop request ends the search with the outcome CANCELLED.
void answer(const v1::ConjugatePointsRequest& request, MemoryLease& memory,
            const std::stop_token& stop, v1::ConjugatePointsResponse* response);

}  // namespace stiefel::server
