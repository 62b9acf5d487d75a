#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
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
/// Returns the bytes of the arrays in the answer of a pair.
std::uint64_t answer_bytes(const ConnectTask& task);
/// Returns the bytes that the search for the geodesic of a pair takes.
std::uint64_t search_bytes(const ConnectTask& task);

/// Joins the pairs on at most `at_once` threads of the crew, and calls `send` with the answer of
/// each, with the work of all searches so far, on one thread at a time. A pair whose search takes
/// more than a limit is joined again, without that limit, after all others. Throws Stopped
/// (stiefel/stop.h) on a stop request, and what `send` throws.
void join(const ConnectTask& task, std::size_t at_once, const std::stop_token& stop,
          const std::function<void(v1::ConnectResponse&)>& send);

/// Answers a ConjugatePoints. `memory` has that of the request; that of the search and of the reply
/// is taken once the request is read. A stop request ends the search with the outcome CANCELLED.
void answer(const v1::ConjugatePointsRequest& request, MemoryLease& memory,
            const std::stop_token& stop, v1::ConjugatePointsResponse* response);

}  // namespace stiefel::server
