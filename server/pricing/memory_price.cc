#include "server/pricing/memory_price.h"

#include <algorithm>

#include "engine/simulation/catalogue/methods/workspace.h"
#include "server/convert/convert.h"
#include "server/convert/reply_limits.h"
#include "server/convert/resolve.h"
#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/sampling.h"
#include "stiefel/connect.h"
#include "stiefel/summary.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// The bytes of a call without its arrays, in gRPC and in the server.
constexpr std::uint64_t call_bytes = 32 << 10;

/// The rows and columns of one member's blocks.
struct Shape {
  double rows = 0, cols = 0;
};

Shape block_shape(const v1::Scene& scene) {
  const double members = std::max<std::uint32_t>(scene.members(), 1);
  Shape largest{3, 3};
  const auto take = [&](double rows, double cols) {
    if (rows * cols > largest.rows * largest.cols) largest = {rows, cols};
  };
  for (const auto& [name, matrix] : scene.initial()) take(matrix.rows() / members, matrix.cols());
  for (const auto& [name, tensor] : scene.initial_tensors()) {
    double size = 1;
    for (const auto extent : tensor.shape()) size *= static_cast<double>(extent);
    if (tensor.shape_size() == 0 || tensor.shape(tensor.shape_size() - 1) == 0) continue;
    const auto cols = static_cast<double>(tensor.shape(tensor.shape_size() - 1));
    take(size / cols / members, cols);
  }
  return largest;
}

/// Returns the bytes of the references of that many members, with up to 58 samples each: attitude
/// and momentum in extended precision.
std::uint64_t references_memory(const v1::Scene& scene, int members) {
  const auto [rows, cols] = block_shape(scene);
  const double held = std::min<double>(scene.members(), members);
  return static_cast<std::uint64_t>(held * 58 * (2 * 16 * rows * cols + 128));
}

}  // namespace

std::uint64_t reply_memory(std::uint64_t array_bytes) { return 3 * array_bytes + call_bytes; }

std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            bool checkpoints) {
  const std::uint64_t sample = sample_bytes(session, fields);
  const std::uint64_t batch = std::max<std::uint64_t>(Sampling::batch_bytes, sample);
  // Batch, message and serialized message, and a sample that needs several messages.
  return call_bytes + 3 * std::min<std::uint64_t>(batch, max_reply_bytes) +
         (sample > max_reply_bytes ? sample : 0) +
         (checkpoints ? 2 * checkpoint_bytes(session) : 0);
}

std::uint64_t reading_memory(const google::protobuf::Message& request) {
  return 2 * static_cast<std::uint64_t>(request.ByteSizeLong()) + call_bytes;
}

std::uint64_t scene_memory(const v1::Scene& scene) {
  // An ensemble needs its description alone, since its members are resolved one after another.
  const std::uint64_t copies = scene.has_members() ? 1 : 3;
  return copies * static_cast<std::uint64_t>(scene.ByteSizeLong()) + 2 * scene_bytes({});
}

std::uint64_t first_step_memory(const Scene& resolved, const v1::Scene& scene) {
  // The state may have twice the arrays of the request.
  return reply_memory(2 * scene.ByteSizeLong()) +
         (resolved.members().empty() ? 0 : simulation_bytes(resolved));
}

std::uint64_t search_memory(const v1::Scene& scene) {
  const auto [rows, cols] = block_shape(scene);
  return largest_simulation_bytes(rows, cols) * 3 / 2 + 2 * scene_memory(scene) +
         references_memory(scene, Choice::most_pilots);
}

std::uint64_t tradeoff_memory(const v1::MeasureTradeoffRequest& request) {
  return reading_memory(request) + search_memory(request.scene()) +
         references_memory(request.scene(), TradeoffRequest::most_members);
}

std::uint64_t fork_memory(const Session& from) {
  return 2 * scene_bytes(from.scene().description()) + call_bytes;
}

std::uint64_t conversion_memory(const v1::ConvertRequest& request) {
  const v1::Scene& scene = request.scene();
  const auto [rows, cols] = block_shape(scene);
  // Frames with n < N rows have maps of n x N and n x n, square ones N x N.
  const auto maps = static_cast<std::uint64_t>(8 * (rows * cols + rows * rows));
  return (wants_choice(scene) ? search_memory(scene) : 0) + reading_memory(request) +
         2 * scene_memory(scene) + 40 * maps;
}

std::uint64_t diagnosis_memory(const Session& session, const v1::DiagnoseRequest& request) {
  return session.simulation_bytes() / 2 + 64 * session.saved_size() + reading_memory(request);
}

std::uint64_t summary_memory(const Session& session, const Summary& summary) {
  const bool keeps_values = std::ranges::any_of(
      summary.description().quantities, [](const Quantity& one) { return !one.quantiles.empty(); });
  // A number of the result needs accumulators of several numbers.
  return session.simulation_bytes() + 6 * summary.statistics_bytes() +
         (keeps_values ? sizeof(double) * Summary::max_kept : 0) + call_bytes;
}

std::uint64_t connect_memory(const v1::ConnectRequest& request) {
  TwoPointProblem problem;
  double numbers = 0;
  const double restarts = request.has_restarts() ? request.restarts() : problem.restarts;
  const double steps = request.steps() > 0 ? request.steps() : 128;
  for (const auto& pair : request.pairs()) {
    const double n = pair.q_0().rows(), N = pair.q_0().cols(), d = n * N - n * (n + 1) / 2;
    numbers = std::max(numbers, (5 * d * d + n * N * d + n * N * (restarts + 3)) * steps +
                                    n * N * (request.samples() + 16.0));
  }
  const double most = static_cast<double>(TwoPointProblem::most_bytes);
  return reading_memory(request) + static_cast<std::uint64_t>(std::min(8 * numbers, most));
}

}  // namespace stiefel::server
