#include "server/convert/answers.h"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/conjugate_points.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

constexpr std::uint32_t max_steps = 4096, max_restarts = 1000;
constexpr std::uint32_t max_samples = 100'000;
constexpr int max_pairs = 1024;

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

std::string path_of(std::size_t pair, const std::string& field) {
  const bool of_pair = field == "Q_0" || field == "Q_T";
  return of_pair ? "pairs[" + std::to_string(pair) + "]." + field : field;
}

class ConnectReader {
 public:
  explicit ConnectReader(const v1::ConnectRequest& request) : request_(request) {}

  OrStatus<ConnectTask> read() {
    check_limits();
    TwoPointProblem common;
    common.time = request_.time();
    common.seed = request_.seed();
    if (request_.has_restarts())
      common.restarts = static_cast<int>(std::min(request_.restarts(), max_restarts));
    if (request_.metric() == v1::METRIC_CANONICAL) common.beta = 0.5;
    if (request_.metric() == v1::METRIC_BETA) common.beta = request_.beta();
    ConnectTask task{{},
                     static_cast<int>(request_.steps()),
                     static_cast<int>(request_.samples()),
                     request_.view() != v1::GEODESIC_VIEW_VELOCITY};
    for (int i = 0; i < std::min(request_.pairs_size(), max_pairs); ++i) {
      stop_point();
      TwoPointProblem one = problem(i, common);
      if (faults_.empty()) task.problems.push_back(std::move(one));
    }
    if (!faults_.empty()) return std::unexpected(errors::invalid(faults_.take()));
    return task;
  }

 private:
  void refuse(std::string field, std::string value, std::string rule) {
    faults_.add(field, std::move(value), std::move(rule));
  }
  void at_most(const char* field, std::uint64_t value, std::uint64_t most) {
    if (value > most)
      refuse(field, std::to_string(value), "must be at most " + std::to_string(most));
  }
  void check_limits() {
    at_most("steps", request_.steps(), max_steps);
    at_most("samples", request_.samples(), max_samples);
    at_most("restarts", request_.restarts(), max_restarts);
    if (request_.pairs_size() < 1 || request_.pairs_size() > max_pairs)
      refuse("pairs", std::to_string(request_.pairs_size()) + " pairs",
             "must be 1 to " + std::to_string(max_pairs));
    const v1::Metric metric = request_.metric();
    if (!v1::Metric_IsValid(metric))
      return refuse("metric", std::to_string(metric), "must be a value of stiefel.v1.Metric");
    const bool has_inertia = metric == v1::METRIC_LAMBDA || metric == v1::METRIC_UNSPECIFIED;
    if (!has_inertia && request_.inertia_size() > 0)
      refuse("inertia", std::to_string(request_.inertia_size()) + " numbers",
             "must be absent with " + v1::Metric_Name(metric));
    if (request_.has_beta() != (metric == v1::METRIC_BETA))
      refuse("beta", request_.has_beta() ? to_text(request_.beta()) : "absent",
             request_.has_beta() ? "must be absent without METRIC_BETA" : "must be given");
    if (!v1::GeodesicView_IsValid(request_.view()))
      refuse("view", std::to_string(request_.view()), "must be a value of stiefel.v1.GeodesicView");
  }

  Eigen::MatrixXd frame(const Path& pair, const char* name, const v1::Matrix* matrix,
                        const v1::Tensor* tensor) {
    const std::string tensor_name = std::string(name) + "_tensor";
    const Path path(pair, name), tensor_path(pair, tensor_name.c_str());
    if (matrix && tensor) {
      faults_.add(tensor_path, "given", std::string("must be absent where ") + name + " is given");
    } else if (tensor) {
      Block block;
      read_block(tensor_path, *tensor, block, faults_);
      if (tensor->shape_size() != 2 || block.imaginary.size() > 0)
        faults_.add(tensor_path, std::to_string(tensor->shape_size()) + " axes",
                    "must be real numbers of shape (n, N)");
      return std::move(block.values);
    } else if (matrix) {
      if (auto block = read_matrix(path, *matrix, faults_)) return std::move(block->values);
    } else {
      faults_.add(path, "absent", "must be given");
    }
    return {};
  }

  TwoPointProblem problem(int index, TwoPointProblem out) {
    const v1::FramePair& given = request_.pairs(index);
    const Path pairs("pairs"), pair(pairs, index);
    out.Q_0 = frame(pair, "Q_0", given.has_q_0() ? &given.q_0() : nullptr,
                    given.has_q_0_tensor() ? &given.q_0_tensor() : nullptr);
    out.Q_T = frame(pair, "Q_T", given.has_q_t() ? &given.q_t() : nullptr,
                    given.has_q_t_tensor() ? &given.q_t_tensor() : nullptr);
    if (request_.metric() == v1::METRIC_EUCLIDEAN)
      out.inertia = Eigen::VectorXd::Ones(out.Q_0.cols());
    else if (!out.beta)
      out.inertia = Eigen::Map<const Eigen::VectorXd>(request_.inertia().data(),
                                                      request_.inertia_size());
    return out;
  }

  const v1::ConnectRequest& request_;
  Faults faults_{in_the_request};
};

/// Returns the error for a refusal; nothing for a search that was stopped or did not succeed.
std::optional<grpc::Status> fault(const ConnectRefusal& refusal, std::size_t pair) {
  if (const auto* invalid = std::get_if<refusal::Invalid>(&refusal))
    return errors::invalid(path_of(pair, invalid->field), invalid->value, invalid->rule);
  if (const auto* frame = std::get_if<refusal::NotOrthonormal>(&refusal))
    return errors::invalid(path_of(pair, frame->field), "max |QQᵀ − I| = " + to_text(frame->defect),
                           "must have orthonormal rows to " + to_text(Scene::frame_tolerance));
  if (const auto* signs = std::get_if<refusal::UnequalDeterminants>(&refusal))
    return errors::unequal_determinants(path_of(pair, "Q_T"), signs->Q_0, signs->Q_T);
  return std::nullopt;
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

Eigen::VectorXd inertia(const v1::ConjugatePointsRequest& request) {
  return Eigen::Map<const Eigen::VectorXd>(request.inertia().data(), request.inertia_size());
}

v1::ConjugatePoint message_of(const ConjugatePoint& point) {
  v1::ConjugatePoint out;
  out.set_time(point.time);
  out.set_multiplicity(static_cast<std::uint32_t>(point.multiplicity));
  for (const Eigen::MatrixXd& one : point.kernel) to_proto(RowMatrix(one), out.add_kernel());
  if (std::isfinite(point.gap)) out.set_gap(point.gap);
  return out;
}

void write(const InjectivityRadius& radius, v1::InjectivityRadius* out) {
  out->set_upper(radius.upper);
  out->set_lower(radius.lower);
  out->set_witness(radius.witness == RadiusWitness::conjugate_point
                       ? v1::RADIUS_WITNESS_CONJUGATE_POINT
                       : v1::RADIUS_WITNESS_CLOSED_GEODESIC);
  to_proto(RowMatrix(radius.Q), out->mutable_q());
  to_proto(RowMatrix(radius.Qdot), out->mutable_qdot());
  out->set_residual(radius.residual);
  if (std::isfinite(radius.least_conjugate)) out->set_least_conjugate(radius.least_conjugate);
  out->set_least_loop(radius.least_loop);
  out->set_starts(static_cast<std::uint32_t>(radius.starts));
  out->set_agreeing(static_cast<std::uint32_t>(radius.agreeing));
  out->set_loops(static_cast<std::uint32_t>(radius.loops));
}

}  // namespace

OrStatus<ConnectTask> read(const v1::ConnectRequest& request) {
  auto task = ConnectReader(request).read();
  if (!task) return task;
  for (std::size_t i = 0; i < task->problems.size(); ++i) {
    stop_point();
    const auto refusal = refusal_of(task->problems[i]);
    if (const auto status = refusal ? fault(*refusal, i) : std::nullopt)
      return std::unexpected(*status);
  }
  return *std::move(task);
}

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
  } else if (const auto status = fault(found.error(), joined.pair)) {
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

std::uint64_t ConjugateAnswer::workspace(const v1::ConjugatePointsRequest& request) {
  const double N = request.inertia_size(),
               n = request.has_radius() ? request.radius().n() : request.q().rows();
  const double most = static_cast<double>(GeodesicRay::most_degrees);
  const double d = std::clamp(n * N - n * (n + 1) / 2, 0.0, most), nN = std::min(n * N, 4 * most);
  // Fields at the stages of a step, matrices of the angles, and the most points of a reply.
  const double points = request.has_radius() ? 0 : GeodesicRay::most_points * (200 + 8 * nN);
  return static_cast<std::uint64_t>(8 * (40 * (d + 1) * nN + 40 * d * d) + 2 * points);
}

double ConjugateAnswer::work() { return GeodesicRay().most_work; }

grpc::Status ConjugateAnswer::along_a_geodesic(const std::stop_token& stop,
                                               v1::ConjugatePointsResponse& response) {
  Faults faults{in_the_request};
  const auto frame = [&](const char* field, bool present, const v1::Matrix& given) {
    if (!present) {
      faults.add(Path(field), "absent", "must be given, unless `radius` is");
      return Eigen::MatrixXd();
    }
    const auto block = read_matrix(Path(field), given, faults);
    return block ? Eigen::MatrixXd(block->values) : Eigen::MatrixXd();
  };
  GeodesicRay ray;
  ray.inertia = inertia(request_);
  ray.Q = frame("Q", request_.has_q(), request_.q());
  ray.Qdot = frame("Qdot", request_.has_qdot(), request_.qdot());
  ray.time = request_.time();
  ray.stop = stop;
  if (!faults.empty()) return errors::invalid(faults.take());
  const auto found = conjugate_points(ray);
  if (!found) return *fault(found.error(), 0);
  for (const ConjugatePoint& point : found->points) points_.push_back(message_of(point));
  response.set_until(found->until);
  to_proto(found->status, response.mutable_run_status());
  return grpc::Status::OK;
}

grpc::Status ConjugateAnswer::of_the_radius(const std::stop_token& stop,
                                            v1::ConjugatePointsResponse& response) {
  if (request_.has_q() || request_.has_qdot() || request_.time() != 0)
    return errors::invalid("radius", "given", "must be given without Q, Qdot and time");
  RadiusProblem problem;
  problem.inertia = inertia(request_);
  problem.n = request_.radius().n();
  problem.seed = request_.radius().seed();
  if (request_.radius().has_starts())
    problem.starts = static_cast<int>(
        std::min<std::uint32_t>(request_.radius().starts(), RadiusProblem::most_starts + 1));
  problem.stop = stop;
  const auto found = injectivity_radius(problem);
  if (!found) {
    const auto* invalid = std::get_if<refusal::Invalid>(&found.error());
    if (invalid && invalid->field != "inertia" && !invalid->field.starts_with("inertia["))
      return errors::invalid("radius." + invalid->field, invalid->value, invalid->rule);
    return *fault(found.error(), 0);
  }
  write(*found, response.mutable_radius());
  to_proto(found->status, response.mutable_run_status());
  return grpc::Status::OK;
}

grpc::Status ConjugateAnswer::next(const std::stop_token& stop,
                                   v1::ConjugatePointsResponse& response) {
  response.Clear();
  if (!std::exchange(started_, true)) {
    const auto status =
        request_.has_radius() ? of_the_radius(stop, response) : along_a_geodesic(stop, response);
    if (!status.ok()) return status;
    std::uint64_t bytes = 0;
    for (const auto& point : points_)
      for (const auto& one : point.kernel())
        bytes += sizeof(double) * static_cast<std::uint64_t>(one.values_size());
    to_proto(work(), bytes, v1::PRICE_BOUND_AT_MOST, memory_, response.mutable_price());
  }
  for (std::size_t sent = 0; !points_.empty() && sent < part_bytes; points_.pop_front()) {
    sent += points_.front().ByteSizeLong();
    *response.add_points() = std::move(points_.front());
  }
  response.set_continues(!points_.empty());
  if (response.has_run_status()) demand_finite(is_finite(response), response.mutable_run_status());
  return grpc::Status::OK;
}

}  // namespace stiefel::server
