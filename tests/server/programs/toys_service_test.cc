#include "proto/checksum/checksum.h"
#include "tests/server/harness.h"
#include "tests/support/toys/toys.h"

// A system without frame and momentum, and a method, which the library does not have, over the
// wire.

namespace stiefel {
namespace {

using testing::toy_scene;

v1::Scene wire(const SceneDescription& description) {
  v1::Scene out;
  server::to_proto(description, &out);
  return out;
}

class ToysOverTheWire : public ::testing::Test {
 protected:
  test::Harness harness_;
  grpc::ClientContext context_;
};

TEST_F(ToysOverTheWire, AreDescribed) {
  v1::DescribeResponse response;
  ASSERT_TRUE(harness_.stub->Describe(&context_, {}, &response).ok());
  const auto& system = response.systems(response.systems_size() - 2);
  EXPECT_EQ(system.name(), "brockett");
  ASSERT_EQ(system.recommended_size(), 1);
  EXPECT_EQ(system.recommended(0).method().name(), "adaptive");
}

TEST_F(ToysOverTheWire, StepWithTheBitsOfTheLibrary) {
  for (const char* method : {"heun", "rk4", "adaptive"}) {
    const SceneDescription description = toy_scene(method);
    const auto made = harness_.create(method, wire(description));
    EXPECT_FALSE(made.session().warnings().empty());
    const auto reply = harness_.step(method, 30);
    EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_REACHED);
    EXPECT_EQ(test::bytes_of(reply.sample()),
              test::expected_bytes(Scene::resolve(description).value(), 30));
  }
}

TEST_F(ToysOverTheWire, AreDiagnosedWithTheirError) {
  harness_.create("s", wire(toy_scene("heun")));
  v1::DiagnoseRequest request;
  request.set_session_id("s");
  request.set_to(20);
  request.set_estimate_error(v1::ERROR_ESTIMATION_ALWAYS);
  v1::DiagnoseResponse response;
  const auto status = harness_.stub->Diagnose(&context_, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(response.invariants_size(), 2);
  EXPECT_EQ(response.invariants(0).name(), "eigenvalues[1]");
  EXPECT_FALSE(response.has_orthogonality());
  EXPECT_FALSE(response.estimated_error().has_attitude());
  EXPECT_GT(response.estimated_error().momentum(), 1e-6);
  EXPECT_LT(response.estimated_error().momentum(), 1e-2);
}

TEST_F(ToysOverTheWire, GetAMethodForATolerance) {
  SceneDescription description = toy_scene();
  description.tolerance = 1e-6;
  description.horizon = 2;
  harness_.create("s", wire(description));
  const auto reply = harness_.step("s", 40);
  ASSERT_EQ(reply.run_status().outcome(), v1::OUTCOME_REACHED);
  double H[4];
  const std::string bytes = test::bytes_of(reply.sample());
  ASSERT_EQ(bytes.size(), sizeof(H));
  std::memcpy(H, bytes.data(), sizeof(H));
  EXPECT_NEAR(H[0], std::tanh(3), 1e-6);
}

TEST_F(ToysOverTheWire, HaveATradeoff) {
  v1::MeasureTradeoffRequest request;
  *request.mutable_scene() = wire(toy_scene());
  request.set_horizon(2);
  request.set_budget(1e8);
  request.set_checksum(true);
  const auto reader = harness_.stub->MeasureTradeoff(&context_, request);
  v1::MeasureTradeoffResponse part;
  int points_of_heun = 0, front = 0;
  while (reader->Read(&part)) {
    EXPECT_TRUE(part.has_checksum());
    EXPECT_EQ(part.checksum(), wire::checksum(part));
    if (part.has_point()) points_of_heun += part.point().method().name() == "heun";
    front += part.has_front();
  }
  const auto status = reader->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_GT(points_of_heun, 3);
  EXPECT_EQ(front, 1);
}

TEST_F(ToysOverTheWire, AreForked) {
  harness_.create("s", wire(toy_scene("rk4")));
  v1::ForkSessionRequest request;
  request.set_session_id("t");
  request.set_from_session_id("s");
  request.set_from_step(7);
  request.mutable_method()->set_name("heun");
  v1::ForkSessionResponse response;
  const auto status = harness_.stub->ForkSession(&context_, request, &response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(test::bytes_of(harness_.step("t", 0).sample()),
            test::bytes_of(harness_.step("s", 7).sample()));
}

}  // namespace
}  // namespace stiefel
