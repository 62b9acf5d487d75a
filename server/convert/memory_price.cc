#include "server/convert/memory_price.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>

#include "server/convert/errors.h"
#include "server/convert/resolve.h"
#include "stiefel/connect.h"
#include "stiefel/price.h"
#include "stiefel/summary.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// The bytes of a call without its arrays, in gRPC and in the server.
constexpr std::uint64_t call_bytes = 32 << 10;

/// The shape of the largest block of one member, at least 3 x 3, of a scene that was read.
struct Shape {
  double rows = 3, cols = 3;

  explicit Shape(const v1::Scene& scene) {
    const double members = std::max<std::uint32_t>(scene.members(), 1);
    for (const auto& [name, matrix] : scene.initial()) take(matrix.rows() / members, matrix.cols());
    for (const auto& [name, tensor] : scene.initial_tensors()) {
      if (tensor.shape().empty() || *tensor.shape().rbegin() == 0) continue;
      double numbers = 1;
      for (const auto extent : tensor.shape()) numbers *= static_cast<double>(extent);
      const auto last = static_cast<double>(*tensor.shape().rbegin());
      take(numbers / last / members, last);
    }
  }
  void take(double more_rows, double more_cols) {
    const double elements = more_rows * more_cols;
    if (elements <= rows * cols) return;
    rows = more_rows;
    cols = more_cols;
  }
};

/// Returns the bytes of a state of the reference, attitude and momentum in extended precision.
double sample(const v1::Scene& scene) {
  const Shape shape(scene);
  return 2 * 16 * shape.rows * shape.cols + 128;
}

/// Returns the number of members whose references are held; 1 for a single motion.
double measured_members(const v1::Scene& scene) {
  return std::min<double>(scene.has_members() ? scene.members() : 1, TradeoffRequest::most_members);
}

/// Returns the bytes of the references of all members, each at up to 58 coarse samples.
std::uint64_t references(const v1::Scene& scene) {
  return static_cast<std::uint64_t>(measured_members(scene) * 58 * sample(scene));
}

/// Returns the bytes of the references of a choice at every step.
std::uint64_t at_every_step(const v1::Scene& scene) {
  const double bytes =
      std::abs(scene.horizon() / scene.step()) * sample(scene) * measured_members(scene);
  return static_cast<std::uint64_t>(bytes <= Choice::most_sample_bytes ? bytes
                                                                       : Choice::most_sample_bytes);
}

/// Returns the bytes of the search for a geodesic between two frames of shape n x N.
std::uint64_t geodesic(double n, double N, const v1::ConnectRequest& request) {
  const double searches = request.has_restarts() ? request.restarts() : TwoPointProblem().restarts;
  const double d = n * N - n * (n + 1) / 2;
  const double points = request.steps() > 0 ? request.steps() : TwoPointProblem::most_path_steps(d);
  const auto [least, most] = std::ranges::minmax_element(request.inertia());
  const bool wide = !request.inertia().empty() && *most > 10 * *least;
  const double nodes = wide ? 127 : 15, each = n * (n + 1) / 2,
               multipliers = std::min(nodes * each, 1500.0),
               modes = n * std::max(15.0, multipliers / each);
  double numbers = n * N * (request.samples() + 200.0);
  if (request.steps() > 0 || d <= 128)
    numbers += (5 * d * d + n * N * d + n * N * (searches + 3)) * points;
  if (request.steps() == 0)
    numbers += (wide ? 5 : 4) * multipliers * multipliers + 8 * modes * modes +
               n * N * (17 * (searches + 5 + n / 2) + 180);
  return static_cast<std::uint64_t>(
      std::clamp(8 * numbers, 0.0, static_cast<double>(TwoPointProblem::most_bytes)));
}

}  // namespace

std::uint64_t memory_price(const CallSizes& sizes) {
  if (sizes.reply > max_reply_bytes) throw errors::reply_too_large(sizes.reply_of, sizes.reply);
  return call_bytes + sizes.request + sizes.workspace + 3 * sizes.reply;
}

std::uint64_t scene_reply(const Session& session) {
  return array_bytes(session.scene().description());
}

std::uint64_t held_by(const google::protobuf::Message& message) {
  const auto* arena = message.GetArena();
  return std::max<std::uint64_t>(message.ByteSizeLong(), arena ? arena->SpaceAllocated() : 0);
}

std::uint64_t scene_workspace(const v1::Scene& scene) {
  // An ensemble needs its description alone, since its members are resolved one after another.
  return (scene.has_members() ? 1 : 3) * held_by(scene) + 2 * scene_bytes({});
}

namespace {

/// Returns the bytes of the scenes and simulations that are measured against references.
std::uint64_t measured_simulations(const v1::Scene& scene) {
  const Shape shape(scene);
  return largest_simulation_bytes(shape.rows, shape.cols) * 3 / 2 + 2 * scene_workspace(scene);
}

}  // namespace

std::uint64_t first_step_workspace(const Scene& resolved) {
  return resolved.members().empty() ? 0 : simulation_bytes(resolved);
}

std::uint64_t choice_workspace(const v1::Scene& scene) {
  return tradeoff_workspace(scene) + at_every_step(scene);
}

std::uint64_t tradeoff_workspace(const v1::Scene& scene) {
  return measured_simulations(scene) + references(scene);
}

std::uint64_t conversion_workspace(const v1::Scene& scene) {
  const Shape shape(scene);
  // Frames with n < N rows have maps of n x N and n x n, square ones N x N.
  const auto maps = static_cast<std::uint64_t>(8 * shape.rows * (shape.cols + shape.rows));
  constexpr int blocks = 6;  // of the reply, at most
  return 40 * maps + 3 * blocks * static_cast<std::uint64_t>(8 * shape.rows * shape.cols);
}

std::uint64_t connect_workspace(const v1::ConnectRequest& request) {
  std::uint64_t largest = 0;
  for (const auto& pair : request.pairs()) {
    const auto& shape = pair.q_0_tensor().shape();
    const bool is_tensor = shape.size() == 2;
    const double n = is_tensor ? static_cast<double>(shape[0]) : pair.q_0().rows(),
                 N = is_tensor ? static_cast<double>(shape[1]) : pair.q_0().cols();
    largest = std::max(largest, geodesic(n, N, request));
  }
  return largest;
}

std::uint64_t diagnosis_workspace(const Session& session) {
  return session.simulation_bytes() / 2 + 64 * session.saved_size();
}

std::uint64_t summary_workspace(const Session& session, const Summary& summary) {
  const bool keeps_values = std::ranges::any_of(
      summary.description().quantities, [](const Quantity& one) { return !one.quantiles.empty(); });
  // A number of the result needs accumulators of several numbers.
  return session.simulation_bytes() + 3 * summary.statistics_bytes() +
         (keeps_values ? sizeof(double) * Summary::max_kept : 0);
}

}  // namespace stiefel::server
