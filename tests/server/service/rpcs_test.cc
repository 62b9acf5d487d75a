#include "server/sessions/identity.h"
#include "stiefel/version.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Rpcs : public testing::Test {
 protected:
  test::Harness harness_;
  grpc::ClientContext context_;
};

TEST_F(Rpcs, DescribeIsTheCatalogueAndTheLimits) {
  v1::DescribeResponse response;
  ASSERT_TRUE(harness_.stub->Describe(&context_, {}, &response).ok());
  EXPECT_EQ(response.build(), build_fingerprint());
  EXPECT_EQ(response.numerics_id(), server::numerics_id());
  EXPECT_EQ(response.numerics_id().size(), 16u);
  EXPECT_EQ(response.numerics_id().find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_EQ(static_cast<std::size_t>(response.systems_size()), catalogue().systems.size());
  EXPECT_EQ(static_cast<std::size_t>(response.methods_size()), catalogue().methods.size());
  EXPECT_EQ(response.limits().max_dimension(), 512u);
  EXPECT_EQ(response.limits().max_sessions(), 1000u);
  EXPECT_EQ(response.limits().max_reply_bytes(), 2u << 20);
  EXPECT_EQ(response.limits().max_step(), std::int64_t{1} << 53);
  EXPECT_EQ(response.limits().idle_timeout().seconds(), 3600);
}

TEST_F(Rpcs, CreateOfALargeSceneWorksOnThePool) {
  EXPECT_TRUE(harness_.create("s", test::wire_scene({.dimension = 40})).created());
}

TEST_F(Rpcs, EveryReplyHasTheNumericsId) {
  const auto id_of = [](const grpc::ClientContext& context) {
    const auto found = context.GetServerInitialMetadata().find("stiefel-numerics-id");
    return found == context.GetServerInitialMetadata().end()
               ? ""
               : std::string(found->second.data(), found->second.size());
  };
  v1::DescribeResponse response;
  ASSERT_TRUE(harness_.stub->Describe(&context_, {}, &response).ok());
  EXPECT_EQ(id_of(context_), server::numerics_id());
  harness_.create("s", test::wire_scene());
  v1::StreamRequest request;
  request.set_session_id("s");
  grpc::ClientContext context;
  const auto reader = harness_.stub->Stream(&context, request);
  v1::StreamResponse message;
  EXPECT_TRUE(reader->Read(&message));
  EXPECT_EQ(id_of(context), server::numerics_id());
  EXPECT_TRUE(reader->Finish().ok());
}

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
