#include "server/convert/geodesics/geodesic_answers.h"

#include <algorithm>
#include <cmath>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "stiefel/conjugate_points.h"

namespace stiefel::server {
namespace {

bool has_numbers(const ConjugatePoint& point) {
  return !std::isnan(point.time) &&
         std::ranges::all_of(point.kernel, [](const auto& one) { return one.allFinite(); });
}

/// Returns the bytes that a search and its reply take.
std::uint64_t workspace(const v1::ConjugatePointsRequest& request) {
  const double N = request.inertia_size(), n = request.q().rows();
  const double most = static_cast<double>(GeodesicRay::most_degrees);
  const double d = std::clamp(n * N - n * (n + 1) / 2, 0.0, most), nN = std::min(n * N, 4 * most);
  // Fields at the stages of a step, matrices of the angles, and the most points of a reply.
  const double points = GeodesicRay::most_points * (200 + 8 * nN);
  return static_cast<std::uint64_t>(8 * (40 * (d + 1) * nN + 40 * d * d) + 3 * points);
}

void write(const ConjugatePoint& point, v1::ConjugatePoint* out) {
  out->set_time(point.time);
  out->set_multiplicity(static_cast<std::uint32_t>(point.multiplicity));
  for (const Eigen::MatrixXd& one : point.kernel) to_proto(RowMatrix(one), out->add_kernel());
  if (std::isfinite(point.gap)) out->set_gap(point.gap);
}

}  // namespace

void answer(const v1::ConjugatePointsRequest& request, MemoryLease& memory,
            const std::stop_token& stop, v1::ConjugatePointsResponse* response) {
  Faults faults{in_the_request};
  GeodesicRay ray;
  ray.inertia = Eigen::Map<const Eigen::VectorXd>(request.inertia().data(), request.inertia_size());
  ray.Q = read_given("Q", request.has_q(), request.q(), faults);
  ray.Qdot = read_given("Qdot", request.has_qdot(), request.qdot(), faults);
  ray.time = request.time();
  ray.stop = stop;
  check(faults);
  memory.grow_to(memory.bytes() + workspace(request));
  const auto found = conjugate_points(ray);
  if (!found) throw_refused(found.error());
  for (const ConjugatePoint& point : found->points) write(point, response->add_points());
  response->set_until(found->until);
  to_proto(found->status, response->mutable_run_status());
  demand_finite(std::ranges::all_of(found->points, has_numbers), response->mutable_run_status());
}

}  // namespace stiefel::server
