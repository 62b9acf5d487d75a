#include "server/convert/geodesics/geodesics.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/simulation.h"

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

std::uint64_t trajectory_bytes(const TwoPointProblem& problem, const ConnectTask& task) {
  const int samples = task.steps > 0 ? task.steps : task.samples;
  return samples > 0 ? sizeof(double) * static_cast<std::uint64_t>(samples + 1) *
                           static_cast<std::uint64_t>(problem.Q_0.size())
                     : 0;
}

v1::Field field_of(const char* name, std::initializer_list<Eigen::Index> shape) {
  v1::Field out;
  out.set_name(name);
  v1::Tensor& tensor = *out.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  for (const Eigen::Index extent : shape) tensor.add_shape(static_cast<std::uint64_t>(extent));
  return out;
}
void append(const Eigen::MatrixXd& block, v1::Field& out) {
  const RowMatrix rows = block;
  out.mutable_value()->mutable_data()->append(reinterpret_cast<const char*>(rows.data()),
                                              static_cast<std::size_t>(rows.size()) *
                                                  sizeof(double));
}

v1::Field trajectory_field(const std::vector<Eigen::MatrixXd>& frames) {
  v1::Field out = field_of("Q", {std::ssize(frames), frames[0].rows(), frames[0].cols()});
  for (const Eigen::MatrixXd& frame : frames) append(frame, out);
  return out;
}

v1::Field velocity_field(const Eigen::MatrixXd& V) {
  v1::Field out = field_of("Qdot", {V.rows(), V.cols()});
  append(V, out);
  return out;
}

/// Moves arrays of at most `room` bytes to `out`, and reduces `room`; no more fit where it is 0.
void fill(Parts& parts, std::size_t& room, Parts::Fields* out) {
  if (parts.empty() || room == 0) return;
  parts.take(room, out);
  std::size_t taken = 0;
  for (const v1::Field& field : *out) taken += field.value().data().size();
  room = parts.empty() && taken < room ? room - taken : 0;
}
void fill(Parts& parts, std::size_t& room, const auto& field_of_message) {
  Parts::Fields taken;
  fill(parts, room, &taken);
  if (!taken.empty()) field_of_message()->Swap(taken.Mutable(0));
}

}  // namespace

std::size_t searches_at_once(const v1::ConnectRequest& request, std::uint64_t bytes_each) {
  constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20, most = 16;
  const auto pairs = static_cast<std::uint64_t>(std::max(request.pairs_size(), 1));
  return std::clamp<std::uint64_t>(most_bytes / std::max<std::uint64_t>(bytes_each, 1), 1,
                                   std::min(pairs, most));
}

ConnectAnswer::ConnectAnswer(ConnectTask task, std::uint64_t memory, std::size_t at_once)
    : task_(std::move(task)), memory_(memory), at_once_(at_once) {
  for (std::size_t i = 0; i < task_.problems.size(); ++i) waiting_.push_back(i);
}

void ConnectAnswer::join(const std::stop_token& stop, double most_work, Joined& joined) const {
  TwoPointProblem problem = task_.problems[joined.pair];
  const double whole_work = problem.most_work;
  problem.stop = stop;
  problem.most_work = std::min(most_work, whole_work);
  v1::ConnectResponse& response = joined.first;
  response.set_pair(static_cast<std::uint32_t>(joined.pair));
  const auto found = joining_scene(problem, task_.steps, task_.samples, task_.with_scene);
  RunStatus run_status;
  bool finite = true;
  if (found) {
    if (found->scene) {
      const SceneDescription& scene = found->scene->description();
      const auto left_out =
          write_view(scene, {}, v1::SCENE_VIEW_FULL, response.mutable_scene());
      for (const SceneArray& array : arrays_of(scene))
        if (std::ranges::find(left_out, array.path) != left_out.end())
          joined.scene_arrays.add(to_field(array));
    }
    response.set_energy(found->energy);
    response.set_residual(found->residual);
    response.set_shortest(shortest(found->shortest));
    response.set_distinct(static_cast<std::uint32_t>(found->distinct));
    const auto send = [&](v1::Field field, Parts& parts) {
      finite = finite && is_finite(field.value());
      parts.add(std::move(field));
    };
    if (found->Qdot.size() > 0) send(velocity_field(found->Qdot), joined.velocity);
    if (!found->trajectory.empty()) send(trajectory_field(found->trajectory), joined.trajectory);
  } else if (const auto status = refused(found.error(), joined.pair)) {
    joined.status = *status;
  } else if (const auto* missed = std::get_if<refusal::NotConverged>(&found.error())) {
    joined.deferred = std::isinf(missed->residual) && problem.most_work < whole_work;
    run_status.outcome = Outcome::solver_stalled;
    response.set_residual(missed->residual);
  } else {
    run_status.outcome = Outcome::cancelled;
  }
  to_proto(run_status, response.mutable_run_status());
  demand_finite(finite && is_finite(response), response.mutable_run_status());
  to_proto(whole_work, trajectory_bytes(problem, task_), v1::PRICE_BOUND_AT_MOST, memory_,
           response.mutable_price());
}

void ConnectAnswer::join_some(const std::stop_token& stop) {
  constexpr double quick = 3e9;  // operations of a pair that is not deferred
  constexpr double nanoseconds_each = 3e5;
  constexpr std::size_t most_bytes = std::size_t{8} << 20;  // of answers that wait to be sent
  const bool again = waiting_.empty();
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::deque<std::size_t>& queue = again ? slow_ : waiting_;
  const TwoPointProblem& one = task_.problems[queue.front()];
  const std::size_t bytes =
      trajectory_bytes(one, task_) + 4 * sizeof(double) * static_cast<std::size_t>(one.Q_0.size());
  // A batch is sent when its last pair is joined, so that slow pairs come in small batches.
  const std::size_t count =
      std::min({queue.size(), again ? std::min(cores, at_once_) : at_once_,
                std::max<std::size_t>(1, most_bytes / bytes)});
  std::vector<Joined> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back({queue[i]});
  queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(count));
  const double most_work = again || task_.problems.size() == 1 ? one.most_work : quick;
  const auto join_one = [&](std::size_t i) { join(stop, most_work, some[i]); };
  if (Crew* crew = count > 1 ? CrewOfThisThread::find() : nullptr)
    crew->run(
        count, nanoseconds_each * static_cast<double>(count),
        [](void* context, std::size_t i) { (*static_cast<decltype(join_one)*>(context))(i); },
        const_cast<void*>(static_cast<const void*>(&join_one)));
  else
    for (std::size_t i = 0; i < count; ++i) join_one(i);
  for (Joined& pair : some) {
    if (pair.deferred)
      slow_.push_back(pair.pair);
    else
      joined_.push_back(std::move(pair));
  }
}

grpc::Status ConnectAnswer::next(const std::stop_token& stop, v1::ConnectResponse& response) {
  while (joined_.empty()) join_some(stop);
  Joined& now = joined_.front();
  if (!now.status.ok()) return now.status;
  response.Clear();
  if (!std::exchange(now.begun, true)) response.Swap(&now.first);
  response.set_pair(static_cast<std::uint32_t>(now.pair));
  std::size_t room = part_bytes;
  fill(now.velocity, room, [&] { return response.mutable_velocity(); });
  fill(now.scene_arrays, room, response.mutable_scene_arrays());
  fill(now.trajectory, room, [&] { return response.mutable_trajectory(); });
  if (now.velocity.empty() && now.scene_arrays.empty() && now.trajectory.empty())
    joined_.pop_front();
  return grpc::Status::OK;
}

}  // namespace stiefel::server
