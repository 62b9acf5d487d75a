#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Rpcs : public testing::Test {
 protected:
  test::Harness harness_;
};

TEST_F(Rpcs, CallsWhoseWorkIsNotKnownHaveACap) {
  v1::Scene scene = test::wire_scene();
  v1::ConvertRequest convert;
  *convert.mutable_scene() = scene;
  convert.set_to("velocity");
  EXPECT_EQ(harness_.convert(convert).front().price().bound(), v1::PRICE_BOUND_AT_MOST);
  scene.clear_method();
  scene.set_tolerance(1e-3);
  scene.set_horizon(1);
  const v1::CreateSessionResponse chosen = harness_.create("s", scene);
  EXPECT_EQ(chosen.price().bound(), v1::PRICE_BOUND_AT_MOST);
  EXPECT_EQ(chosen.price().work(), 4e9);
  EXPECT_FALSE(harness_.create("t", test::wire_scene()).has_price());
}

TEST_F(Rpcs, DiagnoseKeepsTheLargestDriftsOfAFamily) {
  harness_.create("s", test::wire_scene({.method = "rk4", .dimension = 5}));
  const auto diagnose = [&](std::uint32_t most) {
    v1::DiagnoseRequest request;
    request.set_session_id("s");
    request.set_to(100);
    request.add_invariants("spatial_momentum");
    request.set_max_invariants(most);
    grpc::ClientContext context;
    v1::DiagnoseResponse response;
    EXPECT_TRUE(harness_.stub->Diagnose(&context, request, &response).ok());
    EXPECT_EQ(response.price().bound(), v1::PRICE_BOUND_EXPECTED);
    return response;
  };
  const auto all = diagnose(0), some = diagnose(3);
  const double reading = 200 * 5 * 5 * 5;
  EXPECT_GT(all.price().work(), reading) << "its steps besides";
  EXPECT_EQ(some.price().work(), reading) << "the session is at that step";
  ASSERT_EQ(all.invariants_size(), 10);
  EXPECT_EQ(all.shortened_size(), 0);
  ASSERT_EQ(some.invariants_size(), 3);
  ASSERT_EQ(some.shortened_size(), 1);
  EXPECT_EQ(some.shortened(0).name(), "spatial_momentum");
  EXPECT_EQ(some.shortened(0).count(), 10u);
  std::vector<double> drifts;
  for (const auto& invariant : all.invariants()) drifts.push_back(invariant.drift());
  std::ranges::sort(drifts, std::greater());
  for (const auto& invariant : some.invariants()) EXPECT_GE(invariant.drift(), drifts[2]);
}

TEST_F(Rpcs, PricesAreThoseOfTheStepsThatAreMissing) {
  const auto session = harness_.create("s", test::wire_scene()).session();
  const double step = session.step_price().work();
  EXPECT_GT(step, 100);
  EXPECT_EQ(session.step_price().bytes(), 2u * 72);
  EXPECT_EQ(session.step_price().bound(), v1::PRICE_BOUND_EXPECTED);
  EXPECT_EQ(harness_.step("s", 100).price().work(), 100 * step);
  EXPECT_EQ(harness_.step("s", 130).price().work(), 30 * step);
  EXPECT_EQ(harness_.step("s", 130).price().work(), 0);
  auto twice = test::wire_scene();
  twice.mutable_method()->set_substeps(2);
  EXPECT_EQ(harness_.create("t", twice).session().step_price().work(), 2 * step);
  auto adaptive = test::wire_scene();
  adaptive.mutable_method()->set_name("adaptive");
  const double attempt = harness_.create("a", adaptive).session().step_price().work();
  const v1::Price capped = harness_.step("a", 100).price();
  EXPECT_EQ(capped.bound(), v1::PRICE_BOUND_AT_MOST);
  EXPECT_GT(capped.work(), 4 * 100 * attempt);
  EXPECT_LT(capped.work(), 4 * 103 * attempt);
  harness_.create("e", test::wire_scene({.method = "exact"}));
  EXPECT_EQ(harness_.step("e", 1'000'000).price().work(), harness_.step("e", 7).price().work());
}

}  // namespace
}  // namespace stiefel
