// A scene: resolving is idempotent, and the state at a step does not depend on the path.
#include <cmath>

#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/identity.h"
#include "stiefel/diagnosis.h"
#include "tests/fuzz/small.h"
#include "tests/fuzz/target.h"
#include "tests/support/saved.h"

namespace stiefel::fuzz {
namespace {

using testing::saved;

std::optional<Scene> resolved(const v1::Scene& scene) {
  try {
    auto made = resolve_recommending(server::from_proto(scene));
    if (made) return *std::move(made);
    require(!made.error().empty(), "a refusal says what is wrong");
    for (const Violation& violation : made.error())
      require(!violation.field.empty() && !violation.rule.empty(), "it names field and rule");
  } catch (const server::StatusError& refused) {
    require(refused.status.error_code() == grpc::INVALID_ARGUMENT &&
                refused.status.error_message().find(": ") != std::string::npos,
            "it names field and rule");
  }
  return std::nullopt;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

void walk(const Scene& scene) {
  const auto once = make_simulation(scene), twice = make_simulation(scene);
  if (!(once->rate() * std::abs(scene.step()) < 100)) return;  // `adaptive` would take long
  once->advance(3);
  for (int k = 0; k < 3 && twice->advance(1).reached(); ++k)
    ;
  require(once->step() == twice->step() && same_bits(saved(*once), saved(*twice)),
          "the state at a step is one");
  for (const auto& invariant : diagnose(scene, *once).invariants)
    require(!std::isnan(invariant.drift()), "drift of " + invariant.name + " is a number");
}

}  // namespace

std::unique_ptr<google::protobuf::Message> input() { return std::make_unique<v1::Scene>(); }

void run(const google::protobuf::Message& message) {
  auto scene = dynamic_cast<const v1::Scene&>(message);
  if (!make_small(&scene)) return;
  const auto once = resolved(scene);
  if (!once) return;
  v1::Scene printed;
  server::to_proto(once->description(), &printed);
  const auto twice = resolved(printed);
  require(twice &&
              server::identity_of(once->description()) == server::identity_of(twice->description()),
          "a resolved scene resolves to itself");
  walk(*once);
}

}  // namespace stiefel::fuzz
