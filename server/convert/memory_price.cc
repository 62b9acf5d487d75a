#include "server/convert/memory_price.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>

#include "server/convert/resolve.h"
#include "stiefel/connect.h"
#include "stiefel/price.h"
#include "stiefel/summary.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// The bytes of a call without its arrays, in gRPC and in the server.
constexpr std::uint64_t call_bytes = 32 << 10;

/// The shape of the largest block of one member, at least 3 x 3. A block of more elements than a
/// scene may have does not count: it is refused when it is read.
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
    if (elements <= rows * cols || elements > Scene::max_elements) return;
    rows = more_rows;
    cols = more_cols;
  }
};

/// Returns the bytes of a state of the reference, attitude and momentum in extended precision.
double sample(const v1::Scene& scene) {
  const Shape shape(scene);
  return 2 * 16 * shape.rows * shape.cols + 128;
}

/// Returns how many members of a scene are held of at most so many; 1 for a single motion.
double held(const v1::Scene& scene, int most) {
  return std::min<double>(scene.has_members() ? scene.members() : 1, most);
}

/// Returns the bytes of the references of that many members, each at up to 58 coarse samples.
std::uint64_t references(const v1::Scene& scene, int members) {
  return static_cast<std::uint64_t>(held(scene, members) * 58 * sample(scene));
}

/// Returns the bytes of the references of a choice at every step: those of the pilots together and
/// that of one more member.
std::uint64_t at_every_step(const v1::Scene& scene) {
  const double one = std::abs(scene.horizon() / scene.step()) * sample(scene);
  const double most = Choice::most_sample_bytes, pilots = held(scene, Choice::most_pilots);
  const auto at_most = [&](double bytes) { return bytes <= most ? bytes : most; };
  return static_cast<std::uint64_t>(at_most(pilots * one) + (pilots > 1 ? at_most(one) : 0));
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
  return call_bytes + sizes.request + sizes.workspace + 3 * sizes.reply;
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
  return measured_simulations(scene) + references(scene, Choice::most_pilots) +
         at_every_step(scene);
}

std::uint64_t tradeoff_workspace(const v1::Scene& scene) {
  return measured_simulations(scene) + references(scene, TradeoffRequest::most_members);
}

std::uint64_t conversion_workspace(const v1::Scene& scene) {
  const Shape shape(scene);
  // Frames with n < N rows have maps of n x N and n x n, square ones N x N.
  const auto maps = static_cast<std::uint64_t>(8 * shape.rows * (shape.cols + shape.rows));
  return (wants_choice(scene) ? choice_workspace(scene) : 0) + 2 * scene_workspace(scene) +
         40 * maps;
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
  return session.simulation_bytes() + 6 * summary.statistics_bytes() +
         (keeps_values ? sizeof(double) * Summary::max_kept : 0);
}

}  // namespace stiefel::server
