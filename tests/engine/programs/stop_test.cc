// Stop tokens: whoever advances, diagnoses or joins can be told to give up, and what it leaves is a
// state that was reached.
#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <numeric>
#include <set>
#include <thread>

#include "stiefel/connect.h"
#include "stiefel/diagnosis.h"
#include "stiefel/simulation.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::resolved;
using testing::saved;

using namespace std::chrono_literals;

/// A body of N dimensions that turns by about 0.1 in a substep.
SceneDescription body(int N, const std::string& method, int substeps) {
  SceneDescription scene;
  scene.system = "rigid_body";
  scene.method = MethodDescription{method, std::nullopt, substeps, ""};
  scene.step = 0.01 * substeps;
  RowMatrix M(N, N);
  for (int i = 0; i < N; ++i) {
    scene.inertia.push_back(1 + static_cast<double>(i) / N);
    for (int j = 0; j < N; ++j) M(i, j) = (i - j) * (1 + 0.1 * (i + j)) / N / N;
  }
  scene.initial["Q"] = RowMatrix(RowMatrix::Identity(N, N));
  scene.initial["M"] = M;
  return scene;
}

/// How long `work(token)` goes on after it is told to stop, which is 50 ms after its start.
template <class Work>
std::chrono::duration<double> time_to_stop(Work&& work) {
  std::stop_source stop;
  std::chrono::steady_clock::time_point told;
  std::jthread teller([&] {
    std::this_thread::sleep_for(50ms);
    told = std::chrono::steady_clock::now();
    stop.request_stop();
  });
  work(stop.get_token());
  const auto end = std::chrono::steady_clock::now();
  teller.join();
  EXPECT_GE(end, told) << "the work was over before it was told to stop";
  return end - told;
}

void stops_inside_a_step(const Scene& scene) {
  const auto simulation = make_simulation(scene);
  const auto before = saved(*simulation);
  RunStatus status;
  const auto took =
      time_to_stop([&](const std::stop_token& stop) { status = simulation->advance(1, stop); });
  EXPECT_EQ(status.outcome, Outcome::cancelled);
  EXPECT_EQ(simulation->step(), 0);
  EXPECT_EQ(saved(*simulation), before);
  EXPECT_GT(simulation->map_steps(), 0);
  EXPECT_LT(took, 1s);
}

TEST(Stop, ManySubstepsEndBetweenTwoOfThem) {
  stops_inside_a_step(resolved(body(16, "variational", 1'000'000)));
  stops_inside_a_step(resolved(body(16, "rk4", 1'000'000)));
}

TEST(Stop, AnAdaptiveStepEndsBetweenAttempts) {
  SceneDescription scene = body(32, "adaptive", 1);
  scene.method->substeps.reset();
  scene.method->tolerance = 1e-12;
  scene.step = 2000;
  stops_inside_a_step(resolved(scene));
}

TEST(Stop, ATokenThatIsToldAlreadyStopsBeforeTheFirstStep) {
  std::stop_source stop;
  stop.request_stop();
  for (const char* method : {"rk4", "variational", "munthe_kaas4"}) {
    const auto simulation = make_simulation(resolved(body(5, method, 1)));
    EXPECT_EQ(simulation->advance(10, stop.get_token()).outcome, Outcome::cancelled) << method;
    EXPECT_EQ(simulation->map_steps(), 0) << method;
    EXPECT_TRUE(simulation->advance(10).reached()) << method;
    EXPECT_EQ(simulation->step(), 10) << method;
  }
}

/// A stopped ensemble that goes on later has the bits of an ensemble that was not stopped.
TEST(Stop, AnEnsembleGoesBackToWhereAllItsMembersWere) {
  for (const char* method : {"rk4", "munthe_kaas4"}) {
    SceneDescription many = body(3, method, 1);
    constexpr int count = 19;
    many.members = count;
    RowMatrix Q(3 * count, 3), M(3 * count, 3);
    for (int b = 0; b < count; ++b) {
      Q.middleRows(3 * b, 3) = RowMatrix::Identity(3, 3);
      M.middleRows(3 * b, 3) = (1 + 0.01 * b) * many.initial["M"].values;
    }
    many.initial = {{"Q", Block(Q)}, {"M", Block(M)}};
    const Scene scene = resolved(many);
    const auto ensemble = make_simulation(scene), other = make_simulation(scene);
    ASSERT_TRUE(ensemble->advance(7).reached());
    const auto before = saved(*ensemble);
    RunStatus status;
    const auto took = time_to_stop(
        [&](const std::stop_token& stop) { status = ensemble->advance(1'000'000'000, stop); });
    EXPECT_LT(took, 1s);
    EXPECT_EQ(status.outcome, Outcome::cancelled);
    EXPECT_EQ(ensemble->step(), 7);
    EXPECT_EQ(saved(*ensemble), before);
    ASSERT_TRUE(ensemble->advance(30).reached());
    ASSERT_TRUE(other->advance(37).reached());
    EXPECT_EQ(saved(*ensemble), saved(*other)) << method;
  }
}

/// Processor time, since others may have the machine.
template <class Work>
std::clock_t processor_time(Work work) {
  const std::clock_t start = std::clock();
  work();
  return std::clock() - start;
}

/// 4560 components of 10⁶ names. To compare each with each takes about a hundred times as long as
/// to make a set of the names.
TEST(Stop, ManyNamesOfInvariantsAreLookedUpAndNotSearched) {
  const Scene scene = resolved(body(96, "rk4", 1));
  const auto motion = make_simulation(scene);
  std::vector<std::string> names = {"spatial_momentum[0,1]", "energy"};
  for (int i = 0; i < 200'000; ++i) names.push_back("spatial_momentum[0," + std::to_string(i));
  const auto of_a_set = processor_time([&] {
    const std::set<std::string> set(names.begin(), names.end());
    EXPECT_EQ(set.size(), names.size());
  });
  const auto of_the_diagnosis =
      processor_time([&] { EXPECT_EQ(diagnose(scene, *motion, names).invariants.size(), 2u); });
  EXPECT_LT(of_the_diagnosis, 20 * of_a_set);
}

TwoPointProblem between_frames(int N) {
  TwoPointProblem problem;
  problem.inertia = Eigen::VectorXd::LinSpaced(N, 1, 2);
  problem.Q_0 = Eigen::MatrixXd::Identity(N, N);
  problem.Q_T = problem.Q_0;
  problem.Q_T.topLeftCorner(2, 2) << 0.8, 0.6, -0.6, 0.8;
  return problem;
}

TEST(Stop, MoreStepsThanMemoryAreRefusedBeforeTheyAreAllocated) {
  const auto answer = connect(between_frames(16), 4096);
  ASSERT_FALSE(answer);
  const auto* refused = std::get_if<refusal::Invalid>(&answer.error());
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->field, "steps");
  EXPECT_EQ(refused->value, "4096");
  EXPECT_NE(refused->rule.find("must be at most "), std::string::npos) << refused->rule;
  TwoPointProblem many = between_frames(3);
  many.restarts = 100'000'000;
  EXPECT_FALSE(connect(many, 10));
  EXPECT_TRUE(connect(between_frames(3), 64));
}

}  // namespace
}  // namespace stiefel
