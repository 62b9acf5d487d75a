// Stop scopes: every long computation looks at them between its pieces; one that is stopped has no
// result, changes nothing, and gives its bits when it is done again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>

#include "stiefel/catalogue.h"
#include "stiefel/connect.h"
#include "stiefel/conversion.h"
#include "stiefel/diagnosis.h"
#include "stiefel/error_estimate.h"
#include "stiefel/linearization.h"
#include "stiefel/lyapunov.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"
#include "stiefel/tradeoff.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::resolved;

const std::stop_token never;

std::stop_token at_once() {
  std::stop_source source;
  source.request_stop();
  return source.get_token();
}

/// Counts how often a scope is looked at.
struct Looks final : Turn {
  void pass() override { ++count; }
  std::int64_t count = 0;
};

TEST(StopScope, ThrowsWhenATokenOfAnyScopeAroundItRequestsAStop) {
  std::stop_source source;
  const std::stop_token token = source.get_token();
  Looks at_outer, at_inner;
  const StopScope outer(token, at_outer);
  const StopScope inner(never, at_inner);
  stop_point();
  EXPECT_EQ(at_outer.count, 1);
  source.request_stop();
  EXPECT_THROW(stop_point(), Stopped);
  EXPECT_EQ(at_inner.count, 2);
}

TEST(StopScope, ThrowsWhenTheAnnouncedWorkIsUsedUp) {
  const StopScope scope(never, 10);
  stop_point(4);
  stop_point(6);
  EXPECT_FALSE(scope.used_up());
  EXPECT_THROW(stop_point(1), Stopped);
  EXPECT_TRUE(scope.used_up());
  EXPECT_EQ(scope.operations(), 11);
}

TEST(StopScope, EndsWithItsBlockAndBelongsToItsThread) {
  const std::stop_token token = at_once();
  {
    const StopScope scope(token);
    EXPECT_THROW(stop_point(), Stopped);
    std::jthread([] { EXPECT_NO_THROW(stop_point()); });
    const StopScope none = StopScope::nothing();
    EXPECT_NO_THROW(stop_point());
  }
  EXPECT_NO_THROW(stop_point());
}

TEST(StopScope, UnlessStoppedGivesTheResultOrNothing) {
  const auto work = [] {
    stop_point();
    return 7;
  };
  EXPECT_EQ(unless_stopped(never, work), 7);
  const std::stop_token token = at_once();
  EXPECT_EQ(unless_stopped(token, work), std::nullopt);
  const StopScope outer(token);
  EXPECT_THROW(unless_stopped(never, work), Stopped) << "not by its own token";
}

/// ‖Ω‖ is about 1.
SceneDescription body(int N, const std::string& method, double step = 0.05, double widest = 2) {
  SceneDescription scene;
  scene.system = "rigid_body";
  if (!method.empty()) scene.method = MethodDescription{method, std::nullopt, 1, ""};
  scene.step = step;
  RowMatrix M(N, N);
  for (int i = 0; i < N; ++i) scene.inertia.push_back(std::pow(widest, static_cast<double>(i) / N));
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j)
      M(i, j) =
          std::sin(7.0 * (i + 1) * (j + 1)) * (i < j ? 1 : -1) * (i != j) * std::sqrt(1.0 / N);
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < i; ++j) M(i, j) = -M(j, i);
  scene.initial["Q"] = RowMatrix(RowMatrix::Identity(N, N));
  scene.initial["M"] = M;
  return scene;
}

/// The operations that `work` announces, and how many looks they come in.
struct Count {
  double operations;
  std::int64_t looks;
};
template <class Work>
Count count(Work&& work) {
  Looks looks;
  const StopScope scope(never, looks);
  work();
  return {scope.operations(), looks.count};
}

/// `work` is stopped wherever a part of what it announces is used up.
template <class Work>
void stops_everywhere(Work&& work, std::int64_t least_looks) {
  const Count whole = count(work);
  EXPECT_GE(whole.looks, least_looks);
  for (const double part : {0.0, 0.1, 0.5, 0.9, 0.999}) {
    const StopScope scope(never, part * whole.operations);
    EXPECT_THROW(work(), Stopped) << part;
  }
  EXPECT_EQ(count(work).looks, whole.looks) << "done again it is another computation";
}

TEST(StopScope, AStepOfASmallBodyIsWhole) {
  const auto now = make_simulation(resolved(body(6, "implicit_midpoint")));
  Looks looks;
  const StopScope scope(never, looks);
  EXPECT_TRUE(now->advance(3).reached());
  EXPECT_EQ(looks.count, 0);
}

TEST(StopScope, ReachesTheTangentOfEverySystemAndMethod) {
  constexpr int N = 12;
  const Scene base = resolved(body(N, "rk4"));
  std::set<std::string_view> with_tangents, reached;
  for (const SystemInfo& system : catalogue().systems) {
    if (std::ranges::any_of(system.methods, &MethodOnSystem::has_tangent))
      with_tangents.insert(system.name);
    const ConversionTarget target{std::string(system.name)};
    const auto converted = convert(base, target);
    if (!converted || !converted->scene) continue;
    for (const MethodOnSystem& on : system.methods) {
      SceneDescription description = converted->scene->description();
      description.method.reset();
      if (!on.method.empty())
        description.method = MethodDescription{std::string(on.method), std::nullopt, 1, ""};
      const auto scene = Scene::resolve(description);
      if (!scene || !on.has_tangent) continue;  // a method for other N
      const std::string what = scene->system() + " " + scene->method();
      const auto start = make_simulation(*scene);
      if (on.method == "exact") continue;  // its tangent is for N = 3
      reached.insert(system.name);
      const auto basis = (*Linearization::make(*scene, {}, *start))->start_basis(*start);
      const auto work = [&] {
        const auto motion = make_simulation(*scene);
        auto tangent =
            Linearization::make(*scene, {basis.leftCols(4), true, false, false}, *motion);
        ASSERT_TRUE(tangent) << what;
        if ((*tangent)->advance(*motion, 1).outcome == Outcome::cancelled) throw Stopped();
        EXPECT_EQ(motion->step(), 1) << what;
      };
      stops_everywhere(work, N);
    }
  }
  EXPECT_EQ(reached, with_tangents);
}

TEST(StopScope, ReachesTheBasisOfATangentSpaceAndASpectrum) {
  SceneDescription frame = convert(resolved(body(12, "rk4")), {"stiefel"})->scene->description();
  frame.method = MethodDescription{"variational", std::nullopt, 1, ""};
  const Scene scene = resolved(frame);
  const auto motion = make_simulation(scene);
  const auto tangent = Linearization::make(scene, {}, *motion).value();
  const std::int64_t numbers = 2 * 12 * 12;
  stops_everywhere([&] { EXPECT_GT(tangent->basis(*motion).cols(), 12); }, 2 * numbers);
  LyapunovDescription what;
  what.to = 64;
  what.interval = 1;
  what.count = 4;
  stops_everywhere([&] { ASSERT_TRUE(LyapunovExponents::make(scene, what, *motion)); }, numbers);
}

TEST(StopScope, TheSearchForAGeodesicKeepsItsWork) {
  TwoPointProblem problem;
  problem.inertia = Eigen::VectorXd::LinSpaced(6, 1, 2);
  problem.Q_0 = Eigen::MatrixXd::Identity(6, 6);
  problem.Q_T = problem.Q_0;
  problem.Q_T.topLeftCorner(2, 2) << 0.8, 0.6, -0.6, 0.8;
  problem.restarts = 40;
  const Count whole = count([&] { ASSERT_TRUE(connect(problem)); });
  EXPECT_GE(whole.looks, 1000);
  problem.most_work = whole.operations / 2;
  const auto answer = connect(problem);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->shortest, Shortest::ended);
  EXPECT_LE(answer->residual, TwoPointProblem::joined);
  problem.most_work = 1000;
  const auto none = connect(problem);
  ASSERT_FALSE(none);
  EXPECT_TRUE(std::get<refusal::NotConverged>(none.error()).ended);
  problem.stop = at_once();
  const auto cancelled = connect(problem);
  ASSERT_FALSE(cancelled);
  EXPECT_TRUE(std::holds_alternative<refusal::Cancelled>(cancelled.error()));
}

TEST(StopScope, AnEstimateSaysThatItWasCancelled) {
  const Scene scene = resolved(body(8, "rk4"));
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(4).reached());
  EXPECT_TRUE(estimate_error(scene, *now, 5e10, never).missing.empty());
  const std::stop_token token = at_once();
  EXPECT_NE(estimate_error(scene, *now, 5e10, token).missing.find("was cancelled"),
            std::string::npos);
  const StopScope scope(never, 1e4);
  EXPECT_THROW(estimate_error(scene, *now, 5e10, never), Stopped);
}

TEST(StopScope, AChoiceKeepsItsWorkOrIsRefused) {
  for (const int N : {4, 16, 32, 48, 64, 512}) {
    SceneDescription scene = body(N, "");
    scene.tolerance = 1e-10;
    scene.horizon = 50;
    const StopScope scope(never);
    const auto chosen = choose_method(scene);
    EXPECT_LE(scope.operations(), 1.1 * Choice::most_work) << N;
    if (chosen) {
      EXPECT_LE(chosen->work, 1.1 * Choice::most_work) << N;
      EXPECT_GT(chosen->work, 0) << N;
    } else {
      const Violation& refusal = chosen.error().front();
      EXPECT_EQ(refusal.field, "tolerance") << N;
      EXPECT_EQ(refusal.reason, "TOLERANCE_NOT_MET") << N;
      EXPECT_EQ(refusal.metadata.at("most_work"), "4e+09") << N;
    }
    if (N < 32) {
      EXPECT_TRUE(chosen) << N;
    }
    if (N >= 64) {
      ASSERT_FALSE(chosen) << N;
      EXPECT_GT(std::stod(chosen.error().front().metadata.at("reference_work")), 3e9) << N;
      EXPECT_NE(chosen.error().front().rule.find("instructions"), std::string::npos);
    }
  }
}

TEST(StopScope, ATradeoffKeepsItsBudget) {
  TradeoffRequest request{body(24, "")};
  request.budget = 2e9;
  auto survey = Tradeoff::prepare(request).value();
  const StopScope scope(never);
  ASSERT_TRUE(survey->solve_reference(never));
  int points = 0;
  while (survey->next(never)) ++points;
  EXPECT_GT(points, 5);
  EXPECT_LE(scope.operations(), 1.1 * request.budget);
}

}  // namespace
}  // namespace stiefel
