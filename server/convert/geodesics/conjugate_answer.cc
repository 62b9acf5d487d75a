#include "server/convert/geodesics/geodesic_answers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/conjugate_points.h"

namespace stiefel::server {
namespace {

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

std::uint64_t ConjugateAnswer::workspace() const {
  const double N = request_.inertia_size(),
               n = request_.has_radius() ? request_.radius().n() : request_.q().rows();
  const double most = static_cast<double>(GeodesicRay::most_degrees);
  const double d = std::clamp(n * N - n * (n + 1) / 2, 0.0, most), nN = std::min(n * N, 4 * most);
  // Fields at the stages of a step, matrices of the angles, and the most points of a reply.
  const double points = request_.has_radius() ? 0 : GeodesicRay::most_points * (200 + 8 * nN);
  return static_cast<std::uint64_t>(8 * (40 * (d + 1) * nN + 40 * d * d) + 2 * points);
}

grpc::Status ConjugateAnswer::along_a_geodesic(const std::stop_token& stop,
                                               v1::ConjugatePointsResponse& response) {
  Faults faults{in_the_request};
  const auto frame = [&](const char* field, bool present, const v1::Matrix& given) {
    if (!present) {
      faults.add(Path(field), "absent", "must be given, unless `radius` is");
      return Eigen::MatrixXd();
    }
    return Eigen::MatrixXd(read_matrix(Path(field), given, faults).value_or(RowMatrix()));
  };
  GeodesicRay ray;
  ray.inertia = inertia(request_);
  ray.Q = frame("Q", request_.has_q(), request_.q());
  ray.Qdot = frame("Qdot", request_.has_qdot(), request_.qdot());
  ray.time = request_.time();
  ray.stop = stop;
  if (!faults.empty()) return errors::invalid(faults.take());
  memory_.grow_to(memory_.bytes() + workspace());
  const auto found = conjugate_points(ray);
  if (!found) return *refused(found.error());
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
  memory_.grow_to(memory_.bytes() + workspace());
  const auto found = injectivity_radius(problem);
  if (!found) {
    const auto* invalid = std::get_if<refusal::Invalid>(&found.error());
    if (invalid && invalid->field != "inertia" && !invalid->field.starts_with("inertia["))
      return errors::invalid("radius." + invalid->field, invalid->value, invalid->rule);
    return *refused(found.error());
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
