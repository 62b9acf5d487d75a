#include "server/convert/geodesics/geodesic_answers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

v1::Shortest shortest(Shortest value) {
  switch (value) {
    case Shortest::yes:
      return v1::SHORTEST_YES;
    case Shortest::no:
      return v1::SHORTEST_NO;
    case Shortest::none_shorter_found:
      return v1::SHORTEST_NONE_SHORTER_FOUND;
    case Shortest::unknown:
      return v1::SHORTEST_UNKNOWN;
  }
  return v1::SHORTEST_UNSPECIFIED;
}

/// The bytes of answers that wait to be sent, beyond which no search begins.
constexpr std::uint64_t most_waiting_bytes = std::uint64_t{8} << 20;

/// Returns the bytes of the trajectory of frames of `size` numbers.
std::uint64_t trajectory_bytes(std::uint64_t size, std::uint64_t steps, std::uint64_t samples) {
  const std::uint64_t intervals = steps > 0 ? steps : samples;
  return intervals > 0 ? sizeof(double) * (intervals + 1) * size : 0;
}
/// Returns the bytes of an answer with a trajectory of that many bytes.
std::uint64_t answer_bytes(std::uint64_t size, std::uint64_t trajectory) {
  return trajectory + 4 * sizeof(double) * size;
}
std::uint64_t trajectory_bytes(const ConnectTask& task) {
  return trajectory_bytes(static_cast<std::uint64_t>(task.problems[0].Q_0.size()),
                          static_cast<std::uint64_t>(task.steps),
                          static_cast<std::uint64_t>(task.samples));
}

v1::Field trajectory_field(const std::vector<Eigen::MatrixXd>& frames) {
  v1::Field out = to_field("Q", {std::ssize(frames), frames[0].rows(), frames[0].cols()}, {});
  std::string& data = *out.mutable_value()->mutable_data();
  data.reserve(frames.size() * static_cast<std::size_t>(frames[0].size()) * sizeof(double));
  for (const RowMatrix frame : frames)
    data.append(reinterpret_cast<const char*>(frame.data()),
                static_cast<std::size_t>(frame.size()) * sizeof(double));
  return out;
}

}  // namespace

std::size_t searches_at_once(const v1::ConnectRequest& request, std::uint64_t bytes_each,
                             int threads, std::uint64_t most_bytes) {
  const auto pairs = static_cast<std::uint64_t>(std::max(request.pairs_size(), 1));
  return std::clamp<std::uint64_t>(most_bytes / std::max<std::uint64_t>(bytes_each, 1), 1,
                                   std::min(pairs, static_cast<std::uint64_t>(threads)));
}

std::uint64_t waiting_answers_bytes(const v1::ConnectRequest& request) {
  std::uint64_t all = 0, largest = 0;
  for (const v1::FramePair& pair : request.pairs()) {
    const auto size = static_cast<std::uint64_t>(
        pair.has_q_0_tensor() ? pair.q_0_tensor().data().size() / sizeof(double)
                              : static_cast<std::size_t>(pair.q_0().values_size()));
    const std::uint64_t each =
        answer_bytes(size, trajectory_bytes(size, request.steps(), request.samples()));
    largest = std::max(largest, each);
    all += each;
  }
  memory_price({.reply = largest, .reply_of = request.steps() > 0 ? "steps" : "samples"});
  return std::min(all, std::max(most_waiting_bytes, largest)) + largest;
}

ConnectAnswer::ConnectAnswer(ConnectTask task, std::size_t at_once)
    : task_(std::move(task)), at_once_(at_once) {
  for (std::size_t i = 0; i < task_.problems.size(); ++i) waiting_.push_back(i);
}

ConnectAnswer::Joined ConnectAnswer::joined(const std::stop_token& stop,
                                            const Search& search) const {
  Joined joined{search.pair};
  TwoPointProblem problem = task_.problems[joined.pair];
  const double whole_work = problem.most_work;
  problem.stop = stop;
  problem.most_work = std::min(search.most_work, whole_work);
  v1::ConnectResponse& response = joined.response;
  response.set_pair(static_cast<std::uint32_t>(joined.pair));
  const auto found = joining_scene(problem, task_.steps, task_.samples, task_.with_scene);
  RunStatus run_status;
  bool finite = true;
  if (found) {
    if (found->scene) to_proto(found->scene->description(), response.mutable_scene());
    response.set_energy(found->energy);
    response.set_residual(found->residual);
    response.set_shortest(shortest(found->shortest));
    response.set_distinct(static_cast<std::uint32_t>(found->distinct));
    if (found->Qdot.size() > 0) *response.mutable_velocity() = to_field("Qdot", found->Qdot);
    if (!found->trajectory.empty())
      *response.mutable_trajectory() = trajectory_field(found->trajectory);
    finite = is_finite(response.velocity()) && is_finite(response.trajectory());
  } else {
    throw_refused(found.error(), joined.pair);
    const double residual = std::get<refusal::NotConverged>(found.error()).residual;
    joined.deferred = std::isinf(residual) && problem.most_work < whole_work;
    run_status.outcome = Outcome::solver_stalled;
    response.set_residual(residual);
  }
  to_proto(run_status, response.mutable_run_status());
  demand_finite(finite && !std::isnan(response.energy()), response.mutable_run_status());
  if (response.run_status().outcome() == v1::OUTCOME_SOLVER_STALLED) {
    const double residual = response.residual();  // infinite where no path came near
    std::string said = "no geodesic from Q_0 to Q_T was found";
    if (std::isfinite(residual))
      said += (task_.steps > 0 ? "; the largest gradient of the best path is "
                               : "; the best one misses Q_T by ") +
              to_text(residual, 2);
    response.mutable_run_status()->set_message(std::move(said));
  }
  return joined;
}

bool ConnectAnswer::has_room() const {
  const std::size_t held = searching_ + joined_.size();
  const auto size = static_cast<std::uint64_t>(task_.problems[0].Q_0.size());
  return held == 0 ||
         (held + 1) * answer_bytes(size, trajectory_bytes(task_)) <= most_waiting_bytes;
}

bool ConnectAnswer::can_join() const {
  const std::lock_guard lock(mutex_);
  return !(waiting_.empty() && slow_.empty()) && has_room();
}

bool ConnectAnswer::done() const {
  const std::lock_guard lock(mutex_);
  return waiting_.empty() && slow_.empty() && searching_ == 0 && joined_.empty();
}

std::optional<ConnectAnswer::Search> ConnectAnswer::begin_search() {
  constexpr double quick = 3e9;  // operations of a pair that is not deferred
  const std::lock_guard lock(mutex_);
  const bool again = waiting_.empty();
  std::deque<std::size_t>& queue = again ? slow_ : waiting_;
  if (queue.empty() || !has_room()) return std::nullopt;
  const std::size_t pair = queue.front();
  queue.pop_front();
  ++searching_;
  const bool whole = again || task_.problems.size() == 1;
  return Search{pair, whole ? task_.problems[pair].most_work : quick};
}

bool ConnectAnswer::end_search(Joined joined) {
  const std::lock_guard lock(mutex_);
  --searching_;
  const bool answered = !joined.deferred;
  if (answered)
    joined_.push_back(std::move(joined));
  else
    slow_.push_back(joined.pair);
  return answered;
}

void ConnectAnswer::join(const std::stop_token& stop, const std::function<bool()>& pauses,
                         const std::function<void()>& answered) {
  constexpr double nanoseconds_each = 1e9;  // so long that the pieces count as searches
  const auto join_pairs = [&](std::size_t) {
    while (!pauses()) {
      const auto search = begin_search();
      if (!search) return;
      if (end_search(joined(stop, *search))) answered();
    }
  };
  Crew* crew = at_once_ > 1 ? CrewOfThisThread::find() : nullptr;
  if (!crew) return join_pairs(0);
  crew->run(
      at_once_, nanoseconds_each * static_cast<double>(at_once_),
      [](void* context, std::size_t i) { (*static_cast<decltype(join_pairs)*>(context))(i); },
      const_cast<void*>(static_cast<const void*>(&join_pairs)));
}

bool ConnectAnswer::next(v1::ConnectResponse& response) {
  const std::lock_guard lock(mutex_);
  if (joined_.empty()) return false;
  Joined& now = joined_.front();
  response.Swap(&now.response);
  joined_.pop_front();
  return true;
}

}  // namespace stiefel::server
