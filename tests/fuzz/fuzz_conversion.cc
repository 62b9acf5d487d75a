// A scene in other variables, and back: a refusal that says why, or finite numbers.
#include "stiefel/conversion.h"

#include <cmath>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "tests/fuzz/small.h"
#include "tests/fuzz/target.h"

namespace stiefel::fuzz {
namespace {

/// Returns nothing for a scene that is refused.
std::optional<Scene> resolved(const v1::Scene& scene) {
  try {
    if (auto made = resolve_recommending(server::from_proto(scene))) return *std::move(made);
  } catch (const server::StatusError&) {
  }
  return std::nullopt;
}

std::optional<Conversion> converted(const Scene& scene, const ConversionTarget& target) {
  auto conversion = convert(scene, target);
  if (!conversion) {
    const auto* violations = std::get_if<Violations>(&conversion.error());
    require(violations == nullptr || !violations->empty(), "a refusal says what is wrong");
    return std::nullopt;
  }
  for (const auto& [name, block] : conversion->blocks)
    require(block.allFinite(), name + " has finite numbers");
  for (const auto& [domain, margin] : conversion->margins)
    require(!std::isnan(margin), "the margin of " + domain + " is a number");
  return *std::move(conversion);
}

}  // namespace

std::unique_ptr<google::protobuf::Message> input() {
  return std::make_unique<v1::ConvertRequest>();
}

void run(const google::protobuf::Message& message) {
  auto request = dynamic_cast<const v1::ConvertRequest&>(message);
  if (!make_small(request.mutable_scene())) return;
  const auto scene = resolved(request.scene());
  if (!scene) return;
  ConversionTarget target{request.to()};
  if (request.has_epsilon()) target.epsilon = request.epsilon();
  if (request.has_parameter()) target.parameter = request.parameter();
  const auto there = converted(*scene, target);
  if (!there || !there->scene) return;
  ConversionTarget home{scene->system(), scene->description().epsilon,
                        scene->description().parameter};
  converted(*there->scene, home);
}

}  // namespace stiefel::fuzz
