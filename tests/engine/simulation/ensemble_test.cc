#include "engine/motion/ensemble.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/body/body_packs.h"
#include "engine/numbers/pack.h"
#include "stiefel/diagnosis.h"
#include "stiefel/price.h"
#include "tests/support/saved.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel {
namespace {

using testing::description;
using testing::ensemble_of;
using testing::RandomBody;
using testing::resolved;
using testing::saved;

/// Bodies of h‖Ω‖ from a tenth of `step` to `step`.
std::vector<SceneDescription> bodies(int count, const std::string& method, std::optional<int> order,
                                     const std::string& arithmetic, double step, bool frame,
                                     int N = 3) {
  std::vector<SceneDescription> all;
  for (int b = 0; b < count; ++b) {
    RandomBody body(N, static_cast<unsigned>(b + 1));
    body.M *= 0.1 + 0.9 * b / count;
    all.push_back(description(body, step, method, arithmetic));
    if (all.back().method) all.back().method->order = order;
    if (!frame) all.back().initial.erase("Q");
  }
  return all;
}

/// The members' states one after another, each computed alone.
std::vector<double> alone(const std::vector<SceneDescription>& scenes, std::int64_t steps) {
  std::vector<double> all;
  for (const SceneDescription& scene : scenes) {
    const auto simulation = make_simulation(resolved(scene));
    EXPECT_TRUE(simulation->advance(steps).reached());
    const auto state = saved(*simulation);
    all.insert(all.end(), state.begin(), state.end());
  }
  return all;
}

struct Way {
  std::string method;
  std::optional<int> order;
  int N = 3;
};
const Way ways[] = {{"rk4", {}},
                    {"variational", 2},
                    {"variational", 4},
                    {"variational", 6},
                    {"variational", 8},
                    {"preprocessed_variational", 4},
                    {"preprocessed_variational", 10},
                    {"preprocessed_variational", 16},
                    {"rk4", {}, 4},
                    {"variational", 2, 4},
                    {"variational", 6, 4}};

void expect_the_bits_that_they_have_alone(const Way& way, const char* arithmetic,
                                          const char* scalar) {
  for (const bool frame : {true, false})
    for (const int substeps : {1, 3}) {
      auto scenes = bodies(21, way.method, way.order, arithmetic, 0.3, frame, way.N);
      for (auto& scene : scenes) {
        scene.method->substeps = substeps;
        scene.method->scalar = scalar;
      }
      const Scene together = resolved(ensemble_of(scenes));
      ASSERT_TRUE(can_be_packed(together.members().front()));
      const auto once = make_simulation(together), often = make_simulation(together);
      ASSERT_TRUE(once->advance(50).reached());
      for (int k = 0; k < 50; ++k) ASSERT_TRUE(often->advance(1).reached());
      const auto expected = alone(scenes, 50);
      EXPECT_EQ(saved(*once), expected);
      EXPECT_EQ(saved(*often), expected);
    }
}

TEST(Ensemble, BodiesThatGoTogetherHaveTheBitsThatTheyHaveAlone) {
  for (const Way& way : ways)
    for (const char* arithmetic : {"plain", "compensated"})
      for (const char* scalar : {"double", "float"}) {
        if (way.N != 3 && scalar == std::string("float")) continue;
        SCOPED_TRACE(way.method + " " + std::to_string(way.order.value_or(0)) +
                     " N = " + std::to_string(way.N) + " " + arithmetic + " " + scalar);
        expect_the_bits_that_they_have_alone(way, arithmetic, scalar);
      }
}

/// Closed forms side by side, among them bodies that are left to their own simulations: spheres and
/// bodies that turn about an axis.
TEST(Ensemble, ClosedFormsThatGoTogetherHaveTheBitsThatTheyHaveAlone) {
  for (const bool frame : {true, false})
    for (const int substeps : {1, 3}) {
      auto scenes = bodies(21, "exact", {}, "compensated", 0.3, frame, 3);
      for (auto& scene : scenes) scene.method->substeps = substeps;
      scenes[2].inertia = {1, 1, 1};
      scenes[9].initial["M"] = Eigen::Matrix3d{{0, -1, 0}, {1, 0, 0}, {0, 0, 0}};
      const Scene together = resolved(ensemble_of(scenes));
      const auto once = make_simulation(together), often = make_simulation(together);
      ASSERT_TRUE(once->advance(50).reached());
      for (int k = 0; k < 50; ++k) ASSERT_TRUE(often->advance(1).reached());
      const auto expected = alone(scenes, 50);
      EXPECT_EQ(saved(*once), expected);
      EXPECT_EQ(saved(*often), expected);
      ASSERT_TRUE(once->advance(std::int64_t{1} << 60).reached());
      EXPECT_EQ(saved(*once), alone(scenes, (std::int64_t{1} << 60) + 50));
    }
}

/// Steps for which the solver for packs fails in some lanes and succeeds in others.
TEST(Ensemble, HardStepsAreTakenAlone) {
  for (const int N : {3, 4})
    for (const char* arithmetic : {"plain", "compensated"})
      for (const char* scalar : {"double", "float"}) {
        if (N != 3 && scalar == std::string("float")) continue;
        auto scenes = bodies(16, "variational", 2, arithmetic, 1.0, true, N);
        for (auto& scene : scenes) scene.method->scalar = scalar;
        const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
        ASSERT_TRUE(ensemble->advance(200).reached());
        EXPECT_EQ(saved(*ensemble), alone(scenes, 200));
      }
}

/// For a λ < 0 a small |c|² does not prove the branch, so no lane is easy.
TEST(Ensemble, NegativeLambdaInFourDimensionsIsTakenAlone) {
  auto scenes = bodies(8, "variational", 2, "compensated", 0.3, true, 4);
  for (std::size_t b = 0; b < scenes.size(); b += 3) scenes[b].inertia[1] = -0.2;
  const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
  ASSERT_TRUE(ensemble->advance(50).reached());
  EXPECT_EQ(saved(*ensemble), alone(scenes, 50));
}

void expect_hard_steps(int N) {
  const auto scenes = bodies(16, "variational", 2, "plain", 1.0, true, N);
  const Scene together = resolved(ensemble_of(scenes));
  const auto lanes = static_cast<std::size_t>(body_lanes(together));
  int stopped = 0;
  for (std::size_t first = 0; first < scenes.size(); first += lanes) {
    std::vector<PackedBody> some;
    for (const Scene& body : together.members().range(first, lanes))
      some.push_back(packed_body(body));
    const auto packed = pack_bodies(together, some);
    std::vector<double> states;
    for (std::size_t k = first; k < first + lanes; ++k) {
      const auto state = saved(*make_simulation(together.members()[k]));
      states.insert(states.end(), state.begin(), state.end());
    }
    stopped += packed->advance(states, 200).steps < 200;
  }
  EXPECT_GT(stopped, 0) << N;
}

TEST(Ensemble, SomeStepsOfThatAreHard) {
  for (const int N : {3, 4}) expect_hard_steps(N);
}

template <Isa isa, class Scalar>
std::vector<double> after(const BodiesSideBySide<Scalar>& given, std::vector<double> states,
                          std::int64_t steps) {
  constexpr std::size_t lanes = vector_width<Scalar>(isa);
  const auto each = states.size() / 16;
  for (std::size_t k = 0; k < 16; k += lanes) {
    auto some = given;
    const auto rotate = [k](auto& stages) {
      for (auto& stage : stages)
        std::rotate(stage.begin(), stage.begin() + static_cast<std::ptrdiff_t>(k), stage.end());
    };
    rotate(some.stages_3);
    rotate(some.stages_4);
    const auto theirs = std::span(states).subspan(k * each, lanes * each);
    EXPECT_EQ(pack_bodies_on<isa>(some)->advance(theirs, steps).steps, steps);
  }
  return states;
}

template <class Scalar>
void expect_the_same_bits(int N, const char* arithmetic, const char* scalar) {
  auto scenes = bodies(16, "variational", 4, arithmetic, 0.1, true, N);
  for (auto& scene : scenes) scene.method->scalar = scalar;
  const Scene together = resolved(ensemble_of(scenes));
  std::vector<PackedBody> some;
  for (const Scene& body : together.members().range(0, together.members().size()))
    some.push_back(packed_body(body));
  const auto given = side_by_side<Scalar>(together, some, 16);
  std::vector<double> states, expected;
  for (const Scene& body : together.members().range(0, together.members().size())) {
    const auto simulation = make_simulation(body);
    const auto append = [&](std::vector<double>& to) {
      const auto state = saved(*simulation);
      to.insert(to.end(), state.begin(), state.end());
    };
    append(states);
    EXPECT_TRUE(simulation->advance(100).reached());
    append(expected);
  }
  EXPECT_EQ(after<Isa::avx2>(given, states, 100), expected) << N << arithmetic << scalar;
  if (widest_isa() == Isa::avx512) {
    EXPECT_EQ(after<Isa::avx512>(given, states, 100), expected) << N << arithmetic << scalar;
  }
}

TEST(Ensemble, EveryInstructionSetGivesTheSameBits) {
  if (widest_isa() == Isa::baseline) GTEST_SKIP() << "a machine with the baseline alone";
  for (const int N : {3, 4})
    for (const char* arithmetic : {"plain", "compensated"}) {
      expect_the_same_bits<double>(N, arithmetic, "double");
      if (N == 3) expect_the_same_bits<float>(N, arithmetic, "float");
    }
}

/// A body whose numbers are near the ends of the range is not packed.
TEST(Ensemble, ExtremeScalesGoAlone) {
  RandomBody body(3, 1);
  EXPECT_TRUE(can_be_packed(resolved(description(body, 0.1, "rk4"))));
  body.M *= 1e-150;
  EXPECT_FALSE(can_be_packed(resolved(description(body, 0.1, "rk4"))));
  body.M *= 1e143;
  auto in_float = description(body, 0.1, "rk4");
  EXPECT_TRUE(can_be_packed(resolved(in_float)));
  in_float.method->scalar = "float";
  EXPECT_FALSE(can_be_packed(resolved(in_float)));
}

/// The step at which a scene stops, if that is within `steps`.
std::pair<std::int64_t, RunStatus> stop_of(const SceneDescription& scene, std::int64_t steps) {
  const auto simulation = make_simulation(resolved(scene));
  const RunStatus status = simulation->advance(steps);
  return {simulation->step(), status};
}

/// A body whose rk4 diverges, after some steps.
SceneDescription diverging(const SceneDescription& like, std::int64_t steps) {
  for (unsigned seed = 1; seed < 100; ++seed)
    for (double rate = 10; rate < 100; rate *= 1.3) {
      RandomBody body(3, seed, 40);
      body.M *= rate;
      SceneDescription scene = like;
      scene.inertia = {body.lambda.begin(), body.lambda.end()};
      scene.initial["M"] = body.M;
      const auto [step, status] = stop_of(scene, steps);
      if (!status.reached() && step >= 3) return scene;
    }
  throw std::logic_error("none of them diverges");
}

TEST(Ensemble, AllStopWhereTheFirstMemberStops) {
  constexpr std::int64_t steps = 1000;
  auto scenes = bodies(11, "rk4", {}, "plain", 0.3, true);
  scenes[7] = diverging(scenes[7], steps);
  const std::int64_t step = stop_of(scenes[7], steps).first;
  const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
  const RunStatus together = ensemble->advance(steps);
  EXPECT_EQ(together.outcome, Outcome::not_finite);
  EXPECT_EQ(together.member, 7);
  EXPECT_EQ(ensemble->step(), step);
  EXPECT_EQ(saved(*ensemble), alone(scenes, step));
  EXPECT_TRUE(to_sentence(together).starts_with("member 7: "));
}

/// Advances to step `to` in slices of that many steps, and counts them.
RunStatus in_slices(Simulation& ensemble, std::int64_t to, double slice, int* slices) {
  for (; ensemble.step() < to; ++*slices) {
    const auto status = ensemble.advance_slice(to - ensemble.step(), slice);
    if (status && !status->reached()) return *status;
  }
  return {};
}

constexpr double slice_sizes[] = {0.01, 0.7, 5, 1e6};

/// Bodies of which some steps are hard, bodies that are not packed, closed forms.
TEST(Ensemble, InSlicesHasTheSameStates) {
  for (const char* method : {"variational", "adaptive", "exact"}) {
    const auto scenes = bodies(70, method, {}, "", 1.0, true);
    const auto expected = alone(scenes, 100);
    for (const int threads : {1, 3}) {
      limit_threads(threads);
      for (const double slice : slice_sizes) {
        const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
        int slices = 0;
        ASSERT_TRUE(in_slices(*ensemble, 100, slice, &slices).reached());
        EXPECT_EQ(saved(*ensemble), expected) << method << " in " << slices << " slices";
        EXPECT_EQ(slices > 1, slice < 1e6 && !(ensemble->direct() && slice * threads > 1));
      }
    }
  }
}

/// Also when a later group stops before an earlier one.
TEST(Ensemble, InSlicesStopsWhereTheFirstMemberStops) {
  constexpr std::int64_t steps = 1000;
  auto scenes = bodies(70, "rk4", {}, "plain", 0.3, true);
  scenes[7] = scenes[20] = scenes[41] = diverging(scenes[7], steps);
  scenes[41].initial["M"].values *= 1.2;
  const auto whole = make_simulation(resolved(ensemble_of(scenes)));
  const RunStatus expected = whole->advance(steps);
  ASSERT_FALSE(expected.reached());
  EXPECT_EQ(expected.member, 41);
  EXPECT_LT(whole->step(), stop_of(scenes[7], steps).first);
  for (const double slice : slice_sizes) {
    const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
    int slices = 0;
    const RunStatus status = in_slices(*ensemble, steps, slice, &slices);
    EXPECT_EQ(status.outcome, expected.outcome) << slice;
    EXPECT_EQ(status.member, expected.member) << slice;
    EXPECT_EQ(ensemble->step(), whole->step()) << slice;
    EXPECT_EQ(saved(*ensemble), saved(*whole)) << slice;
  }
}

/// Members on their way go back to where all were; also those of which one stopped.
TEST(Ensemble, TurnsBackOnTheWay) {
  auto scenes = bodies(200, "rk4", {}, "plain", 0.3, true);
  scenes[7] = diverging(scenes[7], 1000);
  const auto ensemble = make_simulation(resolved(ensemble_of(scenes)));
  ASSERT_TRUE(ensemble->advance(1).reached());
  const auto expected = alone(scenes, 1);
  std::stop_source stop;
  const auto back = [&](const auto& turn_back) {
    ASSERT_FALSE(ensemble->advance_slice(1000, 300));
    turn_back();
    EXPECT_EQ(saved(*ensemble), expected);
    EXPECT_EQ(ensemble->step(), 1);
  };
  limit_threads(1);
  back([&] { ensemble->turn_back(); });
  back([&] { ensemble->restore(1, expected); });
  back([&] {
    stop.request_stop();
    const auto status = ensemble->advance_slice(1000, 300, stop.get_token());
    EXPECT_EQ(status.value_or(RunStatus{}).outcome, Outcome::cancelled);
  });
  ASSERT_TRUE(ensemble->advance(1).reached());
  EXPECT_EQ(saved(*ensemble), alone(scenes, 2));
}

/// The bound of a repair is relative to the size of S, which is 0 here.
TEST(Ensemble, MembersMayBeAtRest) {
  SceneDescription two;
  two.system = "stiefel";
  two.method = MethodDescription{"variational", {}, {}, ""};
  two.inertia = {1, 2, 3};
  two.step = 0.1;
  two.members = 2;
  two.initial["Q"] = RowMatrix(RowMatrix::Identity(2, 3));
  two.initial["S"] = RowMatrix(RowMatrix::Zero(2, 3));
  const auto scene = Scene::resolve(two);
  ASSERT_TRUE(scene);
  for (const Scene& member : scene->members().range(0, 2)) EXPECT_EQ(member.block("S").norm(), 0);
}

/// A body with these moments, attitude and angular velocity.
SceneDescription given_body(std::vector<double> moments, std::vector<double> attitude,
                            std::vector<double> omega, double step) {
  SceneDescription scene;
  scene.system = "rigid_body";
  scene.method = MethodDescription{"rk4", {}, {}, "plain"};
  scene.step = step;
  scene.body = BodyDescription{{}, std::move(moments), std::move(attitude), std::move(omega)};
  return scene;
}

/// Also where its numbers are checked without a scene of its own.
TEST(Ensemble, AWrongMemberIsRefusedLikeAWrongScene) {
  const std::vector<double> I = {1, 2, 3}, q = {1, 0, 0, 0}, slow = {0, 1e-140, 0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  int refused = 0;
  for (const auto& wrong :
       {given_body({1, -2, 3}, q, slow, 1), given_body({1, 2, 1e160}, q, slow, 1),
        given_body({1e-160, 2, 3}, q, slow, 1), given_body({1, nan, 3}, q, slow, 1),
        given_body(I, {1, 1e-2, 0, 0}, slow, 1), given_body(I, {1, nan, 0, 0}, slow, 1),
        given_body(I, {1 + 1e-7, 0, 0, 0}, slow, 1), given_body(I, q, {1e160, 0, 0}, 1),
        given_body(I, q, {1e20, 0, 0}, 1), given_body({1, 2, 1e100}, q, {0, 0, 1e60}, 1e-60),
        given_body(I, q, {0, nan, 0}, 1), given_body(I, q, {1e-155, 0, 0}, 1e140),
        given_body(I, q, {1e-130, 1e-130, 0}, 1)}) {
    const auto right = given_body(I, q, slow, *wrong.step);
    ASSERT_TRUE(Scene::resolve(right));
    const auto alone = Scene::resolve(wrong);
    const auto together = Scene::resolve(ensemble_of({right, wrong, wrong}));
    ASSERT_EQ(together.has_value(), alone.has_value()) << *wrong.step;
    if (alone) {
      const Scene member = together->members()[1];
      EXPECT_EQ(member.M(), alone->M());
      EXPECT_EQ(member.attitude(), alone->attitude());
      continue;
    }
    ++refused;
    ASSERT_EQ(together.error().size(), alone.error().size());
    for (std::size_t k = 0; k < alone.error().size(); ++k) {
      EXPECT_EQ(together.error()[k].field, alone.error()[k].field);
      EXPECT_EQ(together.error()[k].value, alone.error()[k].value + " (member 1 and others)");
      EXPECT_EQ(together.error()[k].rule, alone.error()[k].rule);
    }
  }
  EXPECT_EQ(refused, 11);
}

/// A list with the numbers of one member holds for all members.
TEST(Ensemble, InertiaMayBeCommon) {
  const auto scenes = bodies(4, "rk4", {}, "plain", 0.1, true);
  auto common = ensemble_of(scenes);
  common.inertia.resize(3);
  const Scene together = resolved(common);
  for (const Scene& member : together.members().range(0, together.members().size()))
    EXPECT_EQ(member.inertia(), together.members()[0].inertia());
}

/// What a session asks before it makes the simulation; also where bodies are packed and others are
/// not.
TEST(Ensemble, TheOutlineIsThatOfItsSimulation) {
  for (const char* method : {"variational", "adaptive", "exact"}) {
    auto scenes = bodies(19, method, {}, "", 0.1, true, 3);
    scenes[5].initial["M"].values *= 1e-210;  // its products are too small to be packed
    const Scene together = resolved(ensemble_of(scenes));
    const auto simulation = make_simulation(together);
    std::vector<double> rates;
    const Outline found = outline_of(
        together, [&](const Scene&, const Simulation& member) { rates.push_back(member.rate()); });
    const Outline expected = outline_of(*simulation);
    EXPECT_EQ(found.saved_size, expected.saved_size) << method;
    EXPECT_EQ(found.step_cost, expected.step_cost) << method;
    EXPECT_EQ(found.direct, expected.direct) << method;
    EXPECT_EQ(found.block_count, expected.block_count) << method;
    ASSERT_EQ(found.fields.size(), expected.fields.size()) << method;
    for (std::size_t i = 0; i < found.fields.size(); ++i) {
      EXPECT_EQ(found.fields[i].name, expected.fields[i].name) << method;
      EXPECT_EQ(found.fields[i].size(), expected.fields[i].size()) << method;
    }
    EXPECT_EQ(rates.size(), 19u);
    EXPECT_EQ(*std::ranges::max_element(rates), simulation->rate()) << method;
  }
}

}  // namespace
}  // namespace stiefel
