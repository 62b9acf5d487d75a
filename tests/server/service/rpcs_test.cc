#include <limits>
#include <set>
#include <string>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Rpcs : public testing::Test {
 protected:
  test::Harness harness_;
};

TEST_F(Rpcs, DiagnoseKeepsTheLargestDriftsOfAFamily) {
  auto large = test::wire_scene({.method = "rk4", .dimension = 92});
  large.set_step(1e-5);  // rk4 leaves the numbers at 0.01
  harness_.create("s", large);
  v1::DiagnoseRequest request;
  request.set_session_id("s");
  request.set_to(10);
  request.add_invariants("spatial_momentum");
  const auto diagnose = [&] {
    grpc::ClientContext context;
    v1::DiagnoseResponse response;
    EXPECT_TRUE(harness_.stub->Diagnose(&context, request, &response).ok());
    EXPECT_GT(response.work(), 0);
    return response;
  };
  const auto some = diagnose();
  constexpr int most = 4096, all = 92 * 91 / 2;
  ASSERT_EQ(some.invariants_size(), most);
  ASSERT_EQ(some.shortened_size(), 1);
  EXPECT_EQ(some.shortened(0).name(), "spatial_momentum");
  EXPECT_EQ(some.shortened(0).count(), static_cast<unsigned>(all));
  double least = std::numeric_limits<double>::infinity();
  std::set<std::string> kept;
  for (const auto& invariant : some.invariants()) {
    least = std::min(least, invariant.drift());
    kept.insert(invariant.name());
  }
  request.clear_invariants();
  for (int i = 0; i < 92; ++i)
    for (int j = i + 1; j < 92; ++j) {
      const auto name = "spatial_momentum[" + std::to_string(i) + "," + std::to_string(j) + "]";
      if (request.invariants_size() < 80 && !kept.contains(name)) request.add_invariants(name);
    }
  const auto others = diagnose();
  EXPECT_EQ(others.invariants_size(), 80);
  EXPECT_EQ(others.shortened_size(), 0);
  for (const auto& invariant : others.invariants()) EXPECT_LE(invariant.drift(), least);
}

TEST_F(Rpcs, ASessionKnowsTheWorkOfItsStep) {
  const auto price = harness_.create("s", test::wire_scene()).session().step_price();
  EXPECT_GT(price.work(), 100);
  EXPECT_EQ(price.bytes(), 2u * 72);
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
