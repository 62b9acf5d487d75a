// "Chaotic" is said of a flow alone: a second motion by a map nearer to it must grow alike.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/growth/confirmation.h"
#include "engine/growth/coordinates.h"
#include "stiefel/catalogue.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/spectra.h"

namespace stiefel {
namespace {

using namespace testing;

TEST(Confirmation, MotionsNextToASeparatrixAreNotChaotic) {
  for (const double aside : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
    for (const double time : {40.0, 400.0, 4000.0}) {
      SceneDescription description;
      description.system = "rigid_body";
      description.method = MethodDescription{"variational", 4, {}, ""};
      description.body = BodyDescription{{}, {1, 2, 3}, {1, 0, 0, 0}, {aside, 1, aside}};
      description.step = 0.1;
      const auto spectrum =
          spectrum_of(resolved(description), {.to = static_cast<std::int64_t>(10 * time)});
      EXPECT_NE(spectrum->kind(), MotionKind::chaotic) << aside << ", " << time << said(spectrum);
    }
}

/// A geodesic of an ellipsoid that starts along its middle ellipse, which is unstable, and `aside`
/// of it in angle.
SceneDescription next_to_the_middle_ellipse(const std::vector<double>& inertia, double aside,
                                            double step, int order = 2) {
  SceneDescription out = geodesic(1, inertia, 1, step, "variational", order);
  const auto N = static_cast<Eigen::Index>(inertia.size());
  const Eigen::Map<const Eigen::RowVectorXd> lambda(inertia.data(), N);
  Eigen::RowVectorXd v = Eigen::RowVectorXd::Zero(N);
  v(N - 1) = 1;
  v.segment(1, N - 2).setConstant(aside);
  const Eigen::RowVectorXd S = v.cwiseProduct(lambda) / std::sqrt(v.cwiseAbs2().dot(lambda));
  out.initial = {{"Q", Block(Dense(Eigen::RowVectorXd::Unit(N, 0)))}, {"S", Block(Dense(S))}};
  return out;
}

/// RATTLE of order 2 moves the integral of Jacobi by about h², so that its map is chaotic next to
/// the middle ellipse, where the flow is integrable. Written out in 80 bits, with the derivatives
/// of its steps, it has S(5000) = 120, 36, 58, 31 for h = 0.05 … 0.00625 on the first of these
/// motions; the flow in quadruple precision 7.0.
TEST(Confirmation, ChaosOfTheMapIsNotThatOfTheFlow) {
  struct Start {
    std::vector<double> inertia;
    double aside, step;
  };
  const std::vector<Start> starts = {
      {{1, 2.6714211514113977, 8.231619453503043}, 8.6519e-4, 0.05},
      {{1, 1.74, 8.03}, 1e-3, 0.1},
      {{1, 2, 7}, 3e-4, 0.1},
      {{1, 2, 5}, 1e-4, 0.1},
      {{1, 2, 6}, 1e-5, 0.2},
      {{1, 2, 3, 9}, 1e-3, 0.1},
  };
  int of_the_map = 0;
  for (const auto& [inertia, aside, step] : starts) {
    const auto to = static_cast<std::int64_t>(5000 / step);
    const auto spectrum = spectrum_of(resolved(next_to_the_middle_ellipse(inertia, aside, step)),
                                      {.to = to, .count = 2});
    EXPECT_NE(spectrum->kind(), MotionKind::chaotic) << said(spectrum);
    of_the_map += spectrum->reason().contains("of the map, not of the flow");
  }
  EXPECT_GE(of_the_map, 4);
  const auto flow =
      spectrum_of(resolved(next_to_the_middle_ellipse(starts[0].inertia, starts[0].aside, 0.1, 8)),
                  {.to = 50000, .count = 2});
  EXPECT_EQ(flow->kind(), MotionKind::regular) << said(flow);
  EXPECT_NEAR(flow->exponents()(0) * 5000, 7, 2) << said(flow);
}

/// Every method next to the unstable rotation in a plane of middle moments, in three and four
/// dimensions: all bodies are integrable (Manakov).
TEST(Confirmation, BodiesNextToAnUnstableRotationAreNotChaoticByAnyMethod) {
  for (const int N : {3, 4})
    for (const MethodOnSystem& on : catalogue().system("rigid_body")->methods) {
      if (!on.has_tangent || (!on.where.empty() && N > 3)) continue;
      for (const double aside : {1e-3, 0.0}) {
        SceneDescription description =
            body(N == 3 ? std::vector<double>{2, 1, 0.1} : std::vector<double>{1, 2.2, 3.1, 4.5}, 7,
                 0.3);
        description.method->name = on.method;
        Dense M = aside * RowMatrix(description.initial["M"].values);
        M(0, N == 3 ? 2 : 3) += N == 3 ? 2 : 4;
        M(N == 3 ? 2 : 3, 0) -= N == 3 ? 2 : 4;
        description.initial["M"] = Block(M);
        const auto spectrum = spectrum_of(resolved(description), {.to = 3000, .count = 2});
        EXPECT_NE(spectrum->kind(), MotionKind::chaotic) << on.method << N << said(spectrum);
      }
    }
}

/// Every system has a second motion, whatever the method of the first.
TEST(Confirmation, ItIsMadeForEverySystem) {
  for (const SystemInfo& system : catalogue().systems)
    for (const MethodOnSystem& on : system.methods) {
      if (!on.has_tangent) continue;
      const Scene scene = Scene::resolve(any_scene(std::string(system.name), std::string(on.method),
                                                   5, 0.1, on.where.empty() ? 4 : 3))
                              .value();
      const auto start = make_simulation(scene);
      const GrowthVectors vectors(scene, *start);
      const Dense x = blocks_of(*start), V = vectors.random(x, 1, 1);
      Confirmation second;
      ASSERT_EQ(second.begin({.scene = scene,
                              .start = *start,
                              .direction = V.reshaped(x.rows(), V.rows() / x.rows()),
                              .interval = 5,
                              .intervals = 40,
                              .fastest = start->rate(),
                              .what = {.count = 2}}),
                "")
          << system.name << " " << on.method;
      while (!second.done()) ASSERT_TRUE(second.advance(100, 1000, {}).reached()) << system.name;
      EXPECT_TRUE(second.run().growth().sums().allFinite()) << system.name;
      EXPECT_NEAR(second.run().growth().time(), 200 * 0.1, 1e-9) << system.name;
      EXPECT_EQ(second.how().empty(), system.discrete) << system.name << second.how();
    }
}

/// A motion that is confirmed by no map fine enough is not called chaotic.
TEST(Confirmation, StepsThatAreTooLongConfirmNothing) {
  const auto spectrum =
      spectrum_of(resolved(geodesic(2, {1, 2, 5, 10, 40}, 1, 0.4)), {.to = 10000, .count = 2});
  EXPECT_EQ(spectrum->kind(), MotionKind::undecided) << said(spectrum);
  EXPECT_TRUE(spectrum->reason().contains("too long")) << said(spectrum);
}

/// Steps of 1 rad of the fastest oscillation, h √(λ_max/λ_min), make a chaotic map of the geodesics
/// of an ellipsoid, which are regular.
TEST(Confirmation, AFlowWhoseStepIsTooLongIsNotChaotic) {
  SceneDescription description = geodesic(1, {1, 4.6, 21.5, 100}, 1, 0.1, "variational", 2);
  const Eigen::RowVector4d lambda(1, 4.6, 21.5, 100), v(-0.3, 0, -0.1, 0.1);
  const Eigen::RowVector4d q = Eigen::RowVector4d(0.5, -0.3, -0.7, 0.4).normalized();
  const Eigen::RowVector4d tangent = v - v.dot(q) * q;
  const double speed = std::sqrt(tangent.cwiseAbs2().dot(lambda));
  description.initial = {{"Q", Block(Dense(q))},
                         {"S", Block(Dense(tangent.cwiseProduct(lambda) / speed))}};
  const auto coarse = spectrum_of(resolved(description), {.to = 30000, .count = 2});
  EXPECT_GT(coarse->exponents()(0), 2 * coarse->errors()(0)) << said(coarse);
  EXPECT_EQ(coarse->kind(), MotionKind::undecided) << said(coarse);
  description.step = 0.0125;
  const auto fine = spectrum_of(resolved(description), {.to = 240000, .count = 2});
  EXPECT_EQ(fine->kind(), MotionKind::regular) << said(fine);
}

/// A run is saved and goes on elsewhere every few steps, in the motion and in the second one; a run
/// that was decided goes on to a later step.
TEST(Confirmation, AConfirmationThatGoesOnHasTheSameBits) {
  const Scene scene = resolved(next_to_the_middle_ellipse({1, 2, 7}, 3e-4, 0.1));
  for (const std::int64_t from : {0, 35}) {
    LyapunovDescription what{.from = from, .to = from + 30000, .count = 2};
    const auto at = [&](std::int64_t step) {
      auto motion = make_simulation(scene);
      EXPECT_TRUE(motion->advance(step).reached());
      return motion;
    };
    auto motion = at(from);
    auto whole = begun(scene, what, *motion);
    while (!whole->done()) ASSERT_TRUE(whole->advance(*motion, 1000).reached());
    ASSERT_TRUE(whole->reason().contains("beside this one, by")) << whole->reason();

    std::string saved;
    int in_the_second = 0;
    for (const std::int64_t to : {20000, 30000}) {
      what.to = from + to;
      for (bool done = false; !done;) {
        motion = at(saved.empty() ? from : LyapunovExponents::saved_step(saved));
        auto part = saved.empty() ? LyapunovExponents::make(scene, what, *motion)
                                  : LyapunovExponents::resume(scene, what, saved, *motion);
        ASSERT_TRUE(part) << part.error().front().rule;
        for (int call = 0; call < 100 && !(*part)->done(); ++call)
          ASSERT_TRUE((*part)->advance(*motion, 100).reached());
        in_the_second += (*part)->covered_steps() > to;
        done = (*part)->done();
        saved = (*part)->save();
        if (!done || to != 30000) continue;
        EXPECT_EQ((*part)->exponents(), whole->exponents());
        EXPECT_EQ((*part)->reason(), whole->reason());
        EXPECT_EQ(saved, whole->save());
      }
    }
    EXPECT_GE(in_the_second, 2);
    motion = at(LyapunovExponents::saved_step(saved));
    auto again = LyapunovExponents::resume(scene, what, saved, *motion);
    ASSERT_TRUE(again);
    while (!(*again)->done()) ASSERT_TRUE((*again)->advance(*motion, 1000).reached());
    EXPECT_EQ((*again)->reason(), whole->reason());
    EXPECT_EQ((*again)->save(), saved);
  }
}

}  // namespace
}  // namespace stiefel
