#include "server/convert/pricing/request_memory.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <optional>

#include "server/convert/resolve.h"
#include "server/pricing/memory_price.h"

namespace stiefel::server {
namespace {

/// Returns the bytes of what is read from a message, as the message itself has them in memory.
std::uint64_t held_by(const google::protobuf::Message& message) {
  const auto* arena = message.GetArena();
  return std::max<std::uint64_t>(message.ByteSizeLong(), arena ? arena->SpaceAllocated() : 0);
}

SceneSize size_of(const v1::Scene& scene) {
  SceneSize size;
  size.bytes = held_by(scene);
  if (scene.has_members()) size.members = scene.members();
  const double members = std::max<std::uint32_t>(scene.members(), 1);
  const auto take = [&](double rows, double cols) {
    if (rows * cols <= size.rows * size.cols) return;
    size.rows = rows;
    size.cols = cols;
  };
  for (const auto& [name, matrix] : scene.initial()) take(matrix.rows() / members, matrix.cols());
  for (const auto& [name, tensor] : scene.initial_tensors()) {
    double numbers = 1;
    for (const auto extent : tensor.shape()) numbers *= static_cast<double>(extent);
    if (tensor.shape_size() == 0 || tensor.shape(tensor.shape_size() - 1) == 0) continue;
    const auto cols = static_cast<double>(tensor.shape(tensor.shape_size() - 1));
    take(numbers / cols / members, cols);
  }
  return size;
}

}  // namespace

std::uint64_t reading_memory(const google::protobuf::Message& request) {
  return reading_memory(held_by(request));
}

std::uint64_t scene_memory(const v1::Scene& scene) { return scene_memory(size_of(scene)); }

std::uint64_t first_step_memory(const Scene& resolved, const v1::Scene& scene) {
  return first_step_memory(resolved, held_by(scene));
}

std::uint64_t search_memory(const v1::Scene& scene) { return search_memory(size_of(scene)); }

std::uint64_t tradeoff_memory(const v1::MeasureTradeoffRequest& request) {
  return tradeoff_memory(held_by(request), size_of(request.scene()));
}

std::uint64_t conversion_memory(const v1::ConvertRequest& request) {
  return conversion_memory(held_by(request), size_of(request.scene()),
                           wants_choice(request.scene()));
}

std::uint64_t diagnosis_memory(const Session& session, const v1::DiagnoseRequest& request) {
  return diagnosis_memory(session, held_by(request));
}

std::uint64_t connect_memory(const v1::ConnectRequest& request) {
  std::optional<std::uint32_t> restarts;
  if (request.has_restarts()) restarts = request.restarts();
  std::uint64_t largest = 0;
  for (const auto& pair : request.pairs())
    largest = std::max(largest, geodesic_memory(pair.q_0().rows(), pair.q_0().cols(), restarts,
                                                request.steps(), request.samples()));
  return reading_memory(request) + largest;
}

}  // namespace stiefel::server
