// The estimated error of Diagnose.
#include "tests/server/harness.h"

namespace stiefel {
namespace {

class Estimate : public testing::Test {
 protected:
  v1::DiagnoseResponse diagnose(std::int64_t to, v1::ErrorEstimation asked) {
    v1::DiagnoseRequest request;
    request.set_session_id("s");
    request.set_to(to);
    request.add_invariants("energy");
    request.set_estimate_error(asked);
    grpc::ClientContext context;
    v1::DiagnoseResponse response;
    const auto status = harness_.stub->Diagnose(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  test::Harness harness_;
};

TEST_F(Estimate, IsMadeOnRequestOnly) {
  harness_.create("s", test::wire_scene());
  EXPECT_FALSE(diagnose(1000, v1::ERROR_ESTIMATION_UNSPECIFIED).has_estimated_error());
  const auto reply = diagnose(1000, v1::ERROR_ESTIMATION_ALWAYS);
  ASSERT_TRUE(reply.has_estimated_error());
  const auto& error = reply.estimated_error();
  // Order 2 at h‖Ω‖ = 0.03 over ten seconds, while the energy is kept to rounding.
  EXPECT_GT(error.attitude(), 1e-5);
  EXPECT_LT(error.attitude(), 1);
  EXPECT_GT(error.angle(), error.attitude() / 2);
  EXPECT_GT(error.momentum(), 1e-6);
  EXPECT_LT(reply.invariants(0).drift(), 1e-13);
  EXPECT_EQ(error.missing(), "");
  EXPECT_LT(error.reference_error(), 1e-12);
  EXPECT_NE(error.reference().find("closed form"), std::string::npos);
  EXPECT_GT(error.work(), 0);
}

TEST_F(Estimate, IsMadeWhereItIsCheaperThanTheRun) {
  harness_.create("s", test::wire_scene({.method = "rk4", .dimension = 20}));
  const auto few = diagnose(2, v1::ERROR_ESTIMATION_IF_CHEAPER).estimated_error();
  EXPECT_FALSE(few.has_attitude());
  EXPECT_NE(few.missing().find("would take"), std::string::npos) << few.missing();
  EXPECT_NE(few.missing().find("the limit is 5.0e+07"), std::string::npos) << few.missing();
  EXPECT_GT(diagnose(2, v1::ERROR_ESTIMATION_ALWAYS).estimated_error().attitude(), 0);
}

TEST_F(Estimate, OfLessThanTenMillisecondsIsMadeWhateverTheRunTakes) {
  harness_.create("s", test::wire_scene());
  const auto few = diagnose(2, v1::ERROR_ESTIMATION_IF_CHEAPER).estimated_error();
  EXPECT_GT(few.attitude(), 0) << few.missing();
  EXPECT_GT(few.work(), few.run_work());
  EXPECT_LT(few.work(), 5e7);
  const auto many = diagnose(20'000, v1::ERROR_ESTIMATION_IF_CHEAPER).estimated_error();
  EXPECT_GT(many.attitude(), 0) << many.missing();
  EXPECT_LT(many.work(), many.run_work());
}

TEST_F(Estimate, OfMoreWorkThanIsAllowedIsRefusedWithItsPrice) {
  harness_.create("s", test::wire_scene({.method = "rk4", .dimension = 200}));
  const auto error = diagnose(1, v1::ERROR_ESTIMATION_ALWAYS).estimated_error();
  EXPECT_FALSE(error.has_attitude() || error.has_momentum());
  EXPECT_NE(error.missing().find("would take"), std::string::npos);
  EXPECT_NE(error.missing().find("5.0e+10"), std::string::npos) << error.missing();
}

}  // namespace
}  // namespace stiefel
