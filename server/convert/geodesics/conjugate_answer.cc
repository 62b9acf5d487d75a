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

bool has_numbers(const ConjugatePoint& point) {
  return !std::isnan(point.time) &&
         std::ranges::all_of(point.kernel, [](const auto& one) { return one.allFinite(); });
}

v1::ConjugatePoint message_of(const ConjugatePoint& point) {
  v1::ConjugatePoint out;
  out.set_time(point.time);
  out.set_multiplicity(static_cast<std::uint32_t>(point.multiplicity));
  for (const Eigen::MatrixXd& one : point.kernel) to_proto(RowMatrix(one), out.add_kernel());
  if (std::isfinite(point.gap)) out.set_gap(point.gap);
  return out;
}

}  // namespace

std::uint64_t ConjugateAnswer::workspace() const {
  const double N = request_.inertia_size(), n = request_.q().rows();
  const double most = static_cast<double>(GeodesicRay::most_degrees);
  const double d = std::clamp(n * N - n * (n + 1) / 2, 0.0, most), nN = std::min(n * N, 4 * most);
  // Fields at the stages of a step, matrices of the angles, and the most points of a reply.
  const double points = GeodesicRay::most_points * (200 + 8 * nN);
  return static_cast<std::uint64_t>(8 * (40 * (d + 1) * nN + 40 * d * d) + 2 * points);
}

void ConjugateAnswer::search(const std::stop_token& stop, v1::ConjugatePointsResponse& response) {
  Faults faults{in_the_request};
  const auto frame = [&](const char* field, bool present, const v1::Matrix& given) {
    if (!present) {
      faults.add(Path(field), "absent", "must be given");
      return Eigen::MatrixXd();
    }
    return Eigen::MatrixXd(read_matrix(Path(field), given, faults));
  };
  GeodesicRay ray;
  ray.inertia =
      Eigen::Map<const Eigen::VectorXd>(request_.inertia().data(), request_.inertia_size());
  ray.Q = frame("Q", request_.has_q(), request_.q());
  ray.Qdot = frame("Qdot", request_.has_qdot(), request_.qdot());
  ray.time = request_.time();
  ray.stop = stop;
  check(faults);
  memory_.grow_to(memory_.bytes() + workspace());
  const auto found = conjugate_points(ray);
  if (!found) throw_refused(found.error());
  for (const ConjugatePoint& point : found->points) points_.push_back(message_of(point));
  response.set_until(found->until);
  to_proto(found->status, response.mutable_run_status());
  demand_finite(std::ranges::all_of(found->points, has_numbers), response.mutable_run_status());
}

void ConjugateAnswer::next(const std::stop_token& stop, v1::ConjugatePointsResponse& response) {
  response.Clear();
  if (!std::exchange(started_, true)) {
    search(stop, response);
  }
  for (std::size_t sent = 0; !points_.empty() && sent < part_bytes; points_.pop_front()) {
    sent += points_.front().ByteSizeLong();
    *response.add_points() = std::move(points_.front());
  }
  response.set_continues(!points_.empty());
}

}  // namespace stiefel::server
