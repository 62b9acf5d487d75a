#include "server/pricing/memory_price.h"

#include <algorithm>

#include "server/sessions/checkpoints/checkpoint_bytes.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/sampling.h"
#include "stiefel/connect.h"
#include "stiefel/price.h"
#include "stiefel/summary.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// The bytes of a call without its arrays, in gRPC and in the server.
constexpr std::uint64_t call_bytes = 32 << 10;

/// Returns the bytes of the references of that many members, each with attitude and momentum in
/// extended precision at up to 58 coarse samples, and in a choice at up to 512 dense ones.
std::uint64_t references_memory(const SceneSize& scene, int members, bool dense) {
  const double held = std::min<double>(scene.members.value_or(1), members);
  const double sample = 2 * 16 * scene.rows * scene.cols + 128;
  const double more = dense ? std::min(512 * sample, 64.0 * (1 << 20)) : 0;
  return static_cast<std::uint64_t>(held * (58 * sample + more));
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

std::uint64_t reading_memory(std::uint64_t request_bytes) { return request_bytes + call_bytes; }

std::uint64_t scene_memory(const SceneSize& scene) {
  // An ensemble needs its description alone, since its members are resolved one after another.
  const std::uint64_t copies = scene.members ? 1 : 3;
  return copies * scene.bytes + 2 * scene_bytes({});
}

std::uint64_t first_step_memory(const Scene& resolved, std::uint64_t given_bytes) {
  // The state may have twice the arrays of the request.
  return reply_memory(2 * given_bytes) +
         (resolved.members().empty() ? 0 : simulation_bytes(resolved));
}

std::uint64_t search_memory(const SceneSize& scene) {
  return largest_simulation_bytes(scene.rows, scene.cols) * 3 / 2 + 2 * scene_memory(scene) +
         references_memory(scene, Choice::most_pilots, true);
}

std::uint64_t tradeoff_memory(std::uint64_t request_bytes, const SceneSize& scene) {
  return reading_memory(request_bytes) + search_memory(scene) +
         references_memory(scene, TradeoffRequest::most_members, false);
}

std::uint64_t fork_memory(const Session& from) {
  return 2 * scene_bytes(from.scene().description()) + call_bytes;
}

std::uint64_t conversion_memory(std::uint64_t request_bytes, const SceneSize& scene,
                                bool chooses_method) {
  // Frames with n < N rows have maps of n x N and n x n, square ones N x N.
  const auto maps =
      static_cast<std::uint64_t>(8 * (scene.rows * scene.cols + scene.rows * scene.rows));
  return (chooses_method ? search_memory(scene) : 0) + reading_memory(request_bytes) +
         2 * scene_memory(scene) + 40 * maps;
}

std::uint64_t diagnosis_memory(const Session& session, std::uint64_t request_bytes) {
  return session.simulation_bytes() / 2 + 64 * session.saved_size() + reading_memory(request_bytes);
}

std::uint64_t summary_memory(const Session& session, const Summary& summary) {
  const bool keeps_values = std::ranges::any_of(
      summary.description().quantities, [](const Quantity& one) { return !one.quantiles.empty(); });
  // A number of the result needs accumulators of several numbers.
  return session.simulation_bytes() + 6 * summary.statistics_bytes() +
         (keeps_values ? sizeof(double) * Summary::max_kept : 0) + call_bytes;
}

std::uint64_t geodesic_memory(double n, double N, std::optional<std::uint32_t> restarts,
                              std::uint32_t steps, std::uint32_t samples) {
  const double searches = restarts ? *restarts : TwoPointProblem().restarts;
  const double points = steps > 0 ? steps : 128;
  const double d = n * N - n * (n + 1) / 2, multipliers = std::min(7.5 * n * (n + 1), 1500.0);
  double numbers = n * N * (samples + 200.0);
  if (steps > 0 || d <= 128) numbers += (5 * d * d + n * N * d + n * N * (searches + 3)) * points;
  if (steps == 0)
    numbers +=
        4 * multipliers * multipliers + 1800 * n * n + n * N * (17 * (searches + 5 + n / 2) + 180);
  return static_cast<std::uint64_t>(
      std::clamp(8 * numbers, 0.0, static_cast<double>(TwoPointProblem::most_bytes)));
}

}  // namespace stiefel::server
