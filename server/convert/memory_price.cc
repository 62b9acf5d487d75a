#include "server/convert/memory_price.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/convert/errors.h"
#include "server/convert/resolve.h"
#include "stiefel/catalogue.h"
#include "stiefel/price.h"
#include "stiefel/summary.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {
namespace {

/// The bytes of a call without its arrays, in gRPC and in the server.
constexpr std::uint64_t call_bytes = 32 << 10;

/// The shape of the largest block of one member, at least 3 x 3.
struct Shape {
  double rows = 3, cols = 3;

  explicit Shape(const SceneDescription& scene) {
    const double members = scene.members.value_or(1);
    for (const auto& [name, block] : scene.initial) {
      const double of_member = static_cast<double>(block.values.rows()) / members;
      const auto across = static_cast<double>(block.values.cols());
      if (of_member * across > elements()) rows = of_member, cols = across;
    }
  }
  double elements() const { return rows * cols; }
  /// The bytes of a state of the reference: attitude and momentum in extended precision.
  double sample() const { return 2 * 16 * elements() + 128; }
};

/// Returns the number of members whose references are held; 1 for a single motion.
double measured_members(const SceneDescription& scene) {
  return std::min(scene.members.value_or(1), TradeoffRequest::most_members);
}

}  // namespace

std::uint64_t memory_price(const CallSizes& sizes) {
  if (sizes.reply > max_reply_bytes) throw errors::reply_too_large(sizes.reply_of, sizes.reply);
  return call_bytes + sizes.request + sizes.workspace + 3 * sizes.reply;
}

std::uint64_t stream_memory(const Session& session, const std::vector<std::size_t>& fields,
                            const Sampling::Range& range) {
  return memory_price(
      {.workspace = range.checkpoints() ? 2 * checkpoint_bytes(session) : 0,
       .reply = std::max<std::uint64_t>(Sampling::batch_bytes, sample_bytes(session, fields))});
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

std::uint64_t first_step_workspace(const Scene& resolved) {
  return resolved.members().empty() ? 0 : simulation_bytes(resolved);
}

std::uint64_t recommendation_workspace(SceneDescription scene) {
  constexpr std::size_t small = 4 << 10;  // N < 16, where a simulation takes 130 kB
  const auto members = static_cast<std::size_t>(std::max(scene.members.value_or(1), 1));
  const auto methods = recommended(scene.system);
  if (methods.empty() || array_bytes(scene) / members < small) return 0;
  scene.method = methods.back().description();  // it takes every scene
  const auto resolved = Scene::resolve(std::move(scene), Scene::frame_tolerance);
  return resolved ? simulation_bytes(*resolved) / members : 0;
}

std::uint64_t choice_workspace(const SceneDescription& scene) {
  // The references at every step.
  const double bytes = std::abs(scene.horizon.value_or(0) / scene.step.value_or(1)) *
                       Shape(scene).sample() * measured_members(scene);
  const double most = Choice::most_sample_bytes;
  return tradeoff_workspace(scene) + static_cast<std::uint64_t>(bytes <= most ? bytes : most);
}

std::uint64_t tradeoff_workspace(const SceneDescription& scene) {
  // Scenes and simulations, and the references of all members, each at up to 58 coarse samples.
  const Shape shape(scene);
  return largest_simulation_bytes(shape.rows, shape.cols) * 3 / 2 +
         (scene.members ? 4 : 12) * array_bytes(scene) + 4 * scene_bytes({}) +
         static_cast<std::uint64_t>(measured_members(scene) * 58 * shape.sample());
}

std::uint64_t conversion_workspace(const Scene& resolved) {
  const Shape shape(resolved.description());
  // Frames with n < N rows have maps of n x N and n x n, square ones N x N.
  constexpr int maps = 40, blocks = 6;  // blocks of the reply, at most
  return static_cast<std::uint64_t>(
      8 * (maps * shape.rows * (shape.cols + shape.rows) + 3 * blocks * shape.elements()));
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
