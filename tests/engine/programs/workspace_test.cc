// The predicted bytes of simulations and scenes, against what malloc has given out.
#include "stiefel/price.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

/// Objects beside matrices, and what allocation rounds up to.
constexpr double slack = 64 << 10;

double allocated() {
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

/// Bytes of a simulation after two steps.
double counted(const Scene& scene) {
  const double before = allocated();
  const auto simulation = make_simulation(scene);
  if (simulation->advance(1).reached()) simulation->advance(1);
  return allocated() - before;
}

/// Not below what is counted, and at most twice it: a row of the table holds for several systems,
/// of which some keep half as many matrices. Returns false for a scene that the method does not
/// take.
bool expect_price(const SceneDescription& description, const std::string& what) {
  const auto scene = Scene::resolve(description);
  if (!scene) {
    EXPECT_TRUE(scene.error().front().field.starts_with("method")) << what;
    return false;
  }
  const double actual = counted(*scene);
  const auto priced = static_cast<double>(simulation_bytes(*scene));
  const auto rule = ::testing::Message() << what << ": malloc has given out " << actual
                                         << " bytes; the row of the method "
                                         << "in engine/motion/workspaces.inc must predict that or "
                                         << "up to twice as much";
  EXPECT_GE(priced, actual - slack) << rule;
  EXPECT_LE(priced, 2 * actual + 8 * slack) << rule;
  return true;
}

std::vector<int> orders_of(std::string_view method) {
  const auto orders = method.empty() ? std::vector<int>() : catalogue().method(method)->orders;
  return orders.empty() ? std::vector{0} : orders;
}

template <class Visit>
void for_each_method(const SystemInfo& system, Visit visit) {
  if (system.discrete) return visit("", 0);
  for (const MethodOnSystem& on : system.methods)
    for (const int order : orders_of(on.method)) visit(std::string(on.method), order);
}

TEST(Workspace, OfEverySystemAndMethod) {
  for (const SystemInfo& system : catalogue().systems)
    for_each_method(system, [&](const std::string& method, int order) {
      int priced = 0;
      const std::string what =
          std::string(system.name) + " " + method + " " + std::to_string(order);
      for (const int N : {4, 16, 48, 3}) {
        if (N == 3 && priced > 0) continue;  // it is for three dimensions only
        auto scene = testing::any_scene(std::string(system.name), method, 1, 0.02, N);
        if (order > 0) scene.method->order = order;
        priced += expect_price(scene, what + " N = " + std::to_string(N));
      }
      EXPECT_GT(priced, 0) << what;
    });
}

TEST(Workspace, OfFramesOfEveryShape) {
  for (const auto& [n, N] : {std::pair{2, 64}, {8, 128}, {32, 96}, {60, 80}, {4, 1000}})
    for_each_method(*catalogue().system("stiefel"), [&](const std::string& method, int order) {
      if (method == "exact") return;  // which takes Λ = I only
      const testing::RandomFrame<double> frame(n, N, 1, 4);
      SceneDescription scene;
      scene.system = "stiefel";
      scene.method = MethodDescription{method, std::nullopt, std::nullopt, ""};
      if (order > 0) scene.method->order = order;
      scene.step = 1e-3;
      scene.inertia.assign(frame.lambda.begin(), frame.lambda.end());
      scene.initial["Q"] = Block(RowMatrix(frame.Q));
      scene.initial["S"] = Block(RowMatrix(frame.S));
      EXPECT_TRUE(expect_price(scene, method + " " + std::to_string(order) + " " +
                                          std::to_string(n) + " x " + std::to_string(N)))
          << method << n << N;
    });
}

/// An ensemble of bodies holds its numbers once, and nothing of each member; then the simulations.
TEST(Workspace, OfMembers) {
  for (const char* method : {"variational", "rk4", "munthe_kaas4"}) {
    std::vector<SceneDescription> bodies;
    for (unsigned b = 0; b < 2000; ++b)
      bodies.push_back(testing::description(testing::RandomBody(3, b + 1), 0.05, method));
    const SceneDescription ensemble = testing::ensemble_of(bodies);
    ASSERT_TRUE(Scene::resolve(ensemble));  // which makes the tables of the first use
    const double before = allocated();
    SceneDescription copy = ensemble;
    const auto scene = Scene::resolve(std::move(copy)).value();
    const double resolved = allocated() - before;
    EXPECT_LE(resolved, 1.1 * static_cast<double>(array_bytes(ensemble))) << method;
    EXPECT_GE(static_cast<double>(scene_bytes(ensemble)), resolved) << method;
    EXPECT_LE(static_cast<double>(scene_bytes(ensemble)), 2 * resolved) << method;
    const double actual = counted(scene);
    EXPECT_GE(static_cast<double>(simulation_bytes(scene)), actual) << method;
    EXPECT_LE(static_cast<double>(simulation_bytes(scene)), 4 * actual) << method;
  }
}

TEST(Workspace, OfALargeScene) {
  const auto body = testing::description(testing::RandomBody(96, 1), 0.01, "rk4");
  ASSERT_TRUE(Scene::resolve(body));  // which makes the tables of the first use
  const double before = allocated();
  SceneDescription copy = body;
  const auto scene = Scene::resolve(std::move(copy)).value();
  const double actual = allocated() - before;
  EXPECT_GE(static_cast<double>(scene_bytes(body)), actual);
  EXPECT_LE(static_cast<double>(scene_bytes(body)), 1.5 * actual + slack);
}

TEST(Workspace, OfTheLargestMethod) {
  for (const int N : {16, 64}) {
    auto scene = testing::description(testing::RandomBody(N, 1), 0.01, "variational");
    scene.method->order = 8;
    EXPECT_GE(static_cast<double>(largest_simulation_bytes(N, N)),
              counted(Scene::resolve(scene).value()));
  }
}

}  // namespace
}  // namespace stiefel
