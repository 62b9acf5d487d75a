#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Rpcs : public testing::Test {
 protected:
  test::Harness harness_;
};

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
    EXPECT_GT(response.work(), 0);
    return response;
  };
  const auto all = diagnose(0), some = diagnose(3);
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

TEST_F(Rpcs, ASessionKnowsTheWorkOfItsStep) {
  const auto price = harness_.create("s", test::wire_scene()).session().step_price();
  EXPECT_GT(price.work(), 100);
  EXPECT_EQ(price.bytes(), 2u * 72);
  EXPECT_GE(price.memory_bytes(), 30 * 3 * 3 * sizeof(double));
  auto twice = test::wire_scene();
  twice.mutable_method()->set_substeps(2);
  EXPECT_EQ(harness_.create("t", twice).session().step_price().work(), 2 * price.work());
}

/// A million steps take a thousand times as long as those that are there already.
TEST_F(Rpcs, AReplySaysTheWorkThatWasDone) {
  harness_.create("s", test::wire_scene());
  const double all = harness_.step("s", 1'000'000).work(),
               none = harness_.step("s", 1'000'000).work();
  EXPECT_GT(none, 0);
  EXPECT_GT(all, 20 * none);
  grpc::ClientContext context;
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(100'000);
  const auto stream = harness_.stub->Stream(&context, request);
  v1::StreamResponse message;
  double before = 0;
  for (; stream->Read(&message); before = message.work()) EXPECT_GT(message.work(), before);
  EXPECT_TRUE(stream->Finish().ok());
}

}  // namespace
}  // namespace stiefel
