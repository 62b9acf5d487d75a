#include "server/convert/geodesics/geodesic_answers.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/scheduling/slice.h"
#include "stiefel/crew.h"
#include "stiefel/simulation.h"

namespace stiefel::server {
namespace {

static_assert(same_order(Shortest::ended, v1::SHORTEST_YES) == v1::SHORTEST_ENDED);

v1::Field trajectory_field(const std::vector<Eigen::MatrixXd>& frames) {
  v1::Field out = to_field("Q", {std::ssize(frames), frames[0].rows(), frames[0].cols()}, {});
  std::string& data = *out.mutable_value()->mutable_data();
  data.reserve(frames.size() * static_cast<std::size_t>(frames[0].size()) * sizeof(double));
  for (const RowMatrix frame : frames)
    data.append(reinterpret_cast<const char*>(frame.data()),
                static_cast<std::size_t>(frame.size()) * sizeof(double));
  return out;
}

/// Returns the processor time of this thread.
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Joins a pair with at most so many operations; returns nothing if they are used up and are fewer
/// than the pair may take.
std::optional<v1::ConnectResponse> answer(const ConnectTask& task, std::size_t pair,
                                          double most_work, const std::stop_token& stop) {
  TwoPointProblem problem = task.problems[pair];
  const bool is_quick = most_work < problem.most_work;
  problem.stop = stop;
  problem.most_work = most_work;
  v1::ConnectResponse out;
  out.set_pair(static_cast<std::uint32_t>(pair));
  v1::RunStatus& status = *out.mutable_run_status();
  const auto found = joining_scene(problem, task.steps, task.samples, task.with_scene);
  if (!found) {
    throw_refused(found.error(), pair);
    const auto [residual, ended] = std::get<refusal::NotConverged>(found.error());
    if (ended && is_quick) return std::nullopt;
    out.set_residual(residual);
    std::string said =
        ended ? "the budget ended the search before it found a geodesic from Q_0 to Q_T"
              : "no geodesic from Q_0 to Q_T was found";
    if (std::isfinite(residual))  // infinite where no path came near
      said += (task.steps > 0 ? "; the largest gradient of the best path is "
                              : "; the best one misses Q_T by ") +
              to_text(residual, 2);
    status.set_outcome(v1::OUTCOME_SOLVER_STALLED);
    status.set_message(std::move(said));
    return out;
  }
  if (found->shortest == Shortest::ended && is_quick) return std::nullopt;
  if (found->scene) to_proto(found->scene->description(), out.mutable_scene());
  out.set_energy(found->energy);
  out.set_residual(found->residual);
  out.set_shortest(same_order(found->shortest, v1::SHORTEST_YES));
  out.set_distinct(static_cast<std::uint32_t>(found->distinct));
  if (found->Qdot.size() > 0) *out.mutable_velocity() = to_field("Qdot", found->Qdot);
  if (!found->trajectory.empty()) *out.mutable_trajectory() = trajectory_field(found->trajectory);
  status.set_outcome(v1::OUTCOME_REACHED);
  demand_finite(
      !std::isnan(found->energy) && is_finite(out.velocity()) && is_finite(out.trajectory()),
      &status);
  return out;
}

}  // namespace

std::uint64_t answer_bytes(const ConnectTask& task) {
  const int intervals = task.steps > 0 ? task.steps : task.samples;
  const int frames = 4 + (intervals > 0 ? intervals + 1 : 0);  // velocity, scene, trajectory
  return sizeof(double) * static_cast<std::uint64_t>(frames) *
         static_cast<std::uint64_t>(task.problems[0].Q_0.size());
}

std::uint64_t search_bytes(const ConnectTask& task) {
  const TwoPointProblem& problem = task.problems[0];
  const auto n = static_cast<double>(problem.Q_0.rows()),
             N = static_cast<double>(problem.Q_0.cols());
  const double searches = problem.restarts, d = n * N - n * (n + 1) / 2;
  const double points = task.steps > 0 ? task.steps : TwoPointProblem::most_path_steps(d);
  const Eigen::VectorXd& inertia = problem.inertia;
  const bool wide = inertia.size() > 0 && inertia.maxCoeff() > 10 * inertia.minCoeff();
  const double nodes = wide ? 127 : 15, each = n * (n + 1) / 2,
               multipliers = std::min(nodes * each, 1500.0),
               modes = n * std::max(15.0, multipliers / each);
  double numbers = n * N * (task.samples + 200.0);
  if (task.steps > 0 || d <= 128)
    numbers += (5 * d * d + n * N * d + n * N * (searches + 3)) * points;
  if (task.steps == 0)
    numbers += (wide ? 5 : 4) * multipliers * multipliers + 8 * modes * modes +
               n * N * (17 * (searches + 5 + n / 2) + 180);
  return static_cast<std::uint64_t>(
      std::clamp(8 * numbers, 0.0, static_cast<double>(TwoPointProblem::most_bytes)));
}

void join(const ConnectTask& task, std::size_t at_once, const std::stop_token& stop,
          const std::function<void(v1::ConnectResponse&)>& send) {
  constexpr double quick = 3e9;  // operations of a pair that is not deferred
  struct Search {
    std::size_t pair;
    double most_work;
  };
  const double whole = task.problems[0].most_work;
  std::mutex taking, sending;
  std::deque<Search> waiting;  // guarded by `taking`
  double seconds = 0;          // of all searches; guarded by `sending`
  for (std::size_t pair = 0; pair < task.problems.size(); ++pair)
    waiting.push_back({pair, task.problems.size() > 1 ? std::min(quick, whole) : whole});
  const auto next = [&]() -> std::optional<Search> {
    const std::lock_guard lock(taking);
    if (waiting.empty()) return std::nullopt;
    const Search first = waiting.front();
    waiting.pop_front();
    return first;
  };
  const auto join_pairs = [&](std::size_t) {
    try {
      while (const auto search = next()) {
        const double start = thread_seconds();
        auto found = answer(task, search->pair, search->most_work, stop);
        const std::lock_guard lock(sending);
        seconds += thread_seconds() - start;
        if (found) {
          found->set_work(1e9 * seconds * instructions_a_nanosecond);
          send(*found);
        } else {
          const std::lock_guard taken(taking);
          waiting.push_back({search->pair, whole});
        }
      }
    } catch (...) {
      const std::lock_guard lock(taking);
      waiting.clear();
      throw;
    }
  };
  Crew* crew = at_once > 1 ? CrewOfThisThread::find() : nullptr;
  if (!crew) return join_pairs(0);
  constexpr double nanoseconds_each = 1e9;  // so long that the pieces count as searches
  crew->run(
      at_once, nanoseconds_each * static_cast<double>(at_once),
      [](void* context, std::size_t i) { (*static_cast<decltype(join_pairs)*>(context))(i); },
      const_cast<void*>(static_cast<const void*>(&join_pairs)));
}

}  // namespace stiefel::server
