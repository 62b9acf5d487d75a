#include "server/convert/request_price.h"

#include <google/protobuf/arena.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/convert/resolve.h"
#include "server/pricing/memory_price.h"
#include "server/pricing/reading_price.h"
#include "server/pricing/work_price.h"
#include "stiefel/connect.h"
#include "stiefel/tradeoff.h"

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

/// Returns the largest number of columns of a block.
std::uint64_t columns(const v1::Scene& scene) {
  std::uint64_t largest = 0;
  for (const auto& [name, matrix] : scene.initial())
    largest = std::max<std::uint64_t>(largest, matrix.cols());
  for (const auto& [name, tensor] : scene.initial_tensors())
    if (!tensor.shape().empty()) largest = std::max(largest, *tensor.shape().rbegin());
  return largest;
}

/// Returns the dimension of a scene, or p + q for complex p x q blocks; at least 3.
double dimension(const v1::Scene& scene) {
  const auto both = static_cast<double>(scene.inertia_u_size()) + scene.inertia_v_size();
  return std::max({both, static_cast<double>(columns(scene)), 3.0});
}

double members(const v1::Scene& scene) { return std::max<std::uint32_t>(scene.members(), 1); }

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

double creation_work(const v1::Scene& scene) {
  return creation_work(dimension(scene), members(scene)) + recommendation_work(scene);
}

double conversion_work(const v1::Scene& scene) {
  return conversion_work(dimension(scene), members(scene));
}

double recommendation_work(const v1::Scene& scene) {
  if (scene.has_method() || scene.has_tolerance()) return 0;
  return recommendation_work(scene.system(), scene.members(), columns(scene));
}

double tradeoff_work(const v1::MeasureTradeoffRequest& request) {
  const double budget = request.has_budget() ? request.budget() : TradeoffRequest::default_budget;
  return std::isfinite(budget) ? std::max(budget, 0.0) : 0;
}

ReadingWork reading_work(const Session& session, const v1::SummarizeRequest& request) {
  const auto last_only = [](const v1::Quantity& quantity) {
    return quantity.quantiles().empty() && quantity.edges().empty() &&
           std::ranges::all_of(quantity.statistics(),
                               [](int asked) { return asked == v1::STATISTIC_LAST; });
  };
  double on_the_way = 0, once = 0;
  for (const v1::Quantity& quantity : request.quantities())
    (last_only(quantity) ? once : on_the_way) += reading_work(session, quantity.name());
  double at_events = 0;
  for (const v1::Event& event : request.events()) at_events += reading_work(session, event.field());
  const auto steps = static_cast<double>(request.to() - request.from());
  const double samples =
      steps / static_cast<double>(std::max<std::int64_t>(request.every(), 1)) + 1;
  return {on_the_way + at_events, samples * on_the_way + steps * at_events + once};
}

double connect_work(const v1::ConnectRequest& request) {
  return TwoPointProblem().most_work * request.pairs_size();
}

}  // namespace stiefel::server
