#include "server/convert/answers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/conjugate_points.h"
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
    ConnectTask task{{}, static_cast<int>(request_.steps()), static_cast<int>(request_.samples())};
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
    if (metric == v1::METRIC_EUCLIDEAN && request_.inertia_size() > 0)
      refuse("inertia", std::to_string(request_.inertia_size()) + " numbers",
             "must be absent with METRIC_EUCLIDEAN");
    if (metric == v1::METRIC_CANONICAL)
      refuse("metric", "METRIC_CANONICAL",
             "must be METRIC_LAMBDA or METRIC_EUCLIDEAN: geodesics of the canonical metric are not "
             "searched");
    else if (!v1::Metric_IsValid(metric))
      refuse("metric", std::to_string(metric), "must be a value of stiefel.v1.Metric");
  }

  Eigen::MatrixXd frame(const Path& path, bool present, const v1::Matrix& given) {
    if (!present) {
      faults_.add(path, "absent", "must be given");
      return {};
    }
    const auto block = read_matrix(path, given, faults_);
    return block ? Eigen::MatrixXd(block->values) : Eigen::MatrixXd();
  }

  TwoPointProblem problem(int index, TwoPointProblem out) {
    const v1::FramePair& given = request_.pairs(index);
    const Path pairs("pairs"), pair(pairs, index);
    out.Q_0 = frame(Path(pair, "Q_0"), given.has_q_0(), given.q_0());
    out.Q_T = frame(Path(pair, "Q_T"), given.has_q_t(), given.q_t());
    out.inertia = request_.metric() == v1::METRIC_EUCLIDEAN
                      ? Eigen::VectorXd::Ones(out.Q_0.cols())
                      : Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(request_.inertia().data(),
                                                                          request_.inertia_size()));
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

/// Returns what `connect` refuses before it searches, by a search that is stopped at once.
std::optional<grpc::Status> check(TwoPointProblem problem, std::size_t pair) {
  std::stop_source stopped;
  stopped.request_stop();
  problem.stop = stopped.get_token();
  problem.restarts = std::min(problem.restarts, 0);
  const auto answer = connect(problem);
  return answer ? std::nullopt : fault(answer.error(), pair);
}

std::uint64_t trajectory_bytes(const TwoPointProblem& problem, const ConnectTask& task) {
  const int samples = task.steps > 0 ? task.steps : task.samples;
  return samples > 0 ? sizeof(double) * static_cast<std::uint64_t>(samples + 1) *
                           static_cast<std::uint64_t>(problem.Q_0.size())
                     : 0;
}

v1::Field trajectory_field(const std::vector<Eigen::MatrixXd>& frames) {
  v1::Field out;
  out.set_name("Q");
  v1::Tensor& tensor = *out.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  tensor.add_shape(frames.size());
  tensor.add_shape(static_cast<std::uint64_t>(frames[0].rows()));
  tensor.add_shape(static_cast<std::uint64_t>(frames[0].cols()));
  for (const RowMatrix frame : frames)
    tensor.mutable_data()->append(reinterpret_cast<const char*>(frame.data()),
                                  static_cast<std::size_t>(frame.size()) * sizeof(double));
  return out;
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
    if (const auto status = check(task->problems[i], i)) return std::unexpected(*status);
  }
  return *std::move(task);
}

grpc::Status ConnectAnswer::join(const std::stop_token& stop, v1::ConnectResponse& response) {
  TwoPointProblem problem = task_.problems[pair_];
  problem.stop = stop;
  const auto joined = joining_scene(problem, task_.steps, task_.samples);
  RunStatus run_status;
  if (joined) {
    to_proto(joined->scene.description(), response.mutable_scene());
    response.set_energy(joined->energy);
    response.set_residual(joined->residual);
    response.set_shortest(shortest(joined->shortest));
    response.set_distinct(static_cast<std::uint32_t>(joined->distinct));
    if (!joined->trajectory.empty()) trajectory_.add(trajectory_field(joined->trajectory));
  } else if (const auto status = fault(joined.error(), pair_)) {
    return *status;
  } else if (const auto* missed = std::get_if<refusal::NotConverged>(&joined.error())) {
    run_status.outcome = Outcome::solver_stalled;
    response.set_residual(missed->residual);
  } else {
    run_status.outcome = Outcome::cancelled;
  }
  to_proto(run_status, response.mutable_run_status());
  to_proto(problem.most_work, trajectory_bytes(problem, task_), v1::PRICE_BOUND_AT_MOST, memory_,
           response.mutable_price());
  ++pair_;
  return grpc::Status::OK;
}

grpc::Status ConnectAnswer::next(const std::stop_token& stop, v1::ConnectResponse& response) {
  response.Clear();
  if (trajectory_.empty()) {
    const grpc::Status status = join(stop, response);
    if (!status.ok()) return status;
  }
  response.set_pair(static_cast<std::uint32_t>(pair_ - 1));
  if (!trajectory_.empty()) {
    Parts::Fields parts;
    trajectory_.take(part_bytes, &parts);
    response.mutable_trajectory()->Swap(parts.Mutable(0));
  }
  demand_finite(is_finite(response), response.mutable_run_status());
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
