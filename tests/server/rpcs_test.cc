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
  EXPECT_EQ(static_cast<std::size_t>(response.systems_size()), catalogue().systems.size());
  EXPECT_EQ(static_cast<std::size_t>(response.methods_size()), catalogue().methods.size());
  EXPECT_EQ(response.limits().max_dimension(), 512u);
  EXPECT_EQ(response.limits().max_sessions(), 1000u);
  EXPECT_EQ(response.limits().max_step(), std::int64_t{1} << 53);
  EXPECT_EQ(response.limits().idle_timeout().seconds(), 3600);
}

TEST_F(Rpcs, CreateAnswersWithTheResolvedScene) {
  const auto first = harness_.create("s", test::wire_scene());
  EXPECT_TRUE(first.created());
  EXPECT_EQ(first.session().scene().method().order(), 2u);
  EXPECT_EQ(first.session().scene().method().substeps(), 1u);
  EXPECT_EQ(first.session().scene().method().arithmetic(), "compensated");
  EXPECT_EQ(first.session().expire_time().seconds() - first.session().create_time().seconds(),
            3600);
  EXPECT_FALSE(harness_.create("s", test::wire_scene()).created());
  EXPECT_FALSE(harness_.create("s", first.session().scene()).created());
}

TEST_F(Rpcs, CreateOfALargeSceneWorksOnThePool) {
  EXPECT_TRUE(harness_.create("s", test::wire_scene({.dimension = 40})).created());
}

TEST_F(Rpcs, GetShowsTheCache) {
  harness_.create("s", test::wire_scene());
  harness_.step("s", 42);
  v1::GetSessionRequest request;
  request.set_session_id("s");
  v1::GetSessionResponse response;
  ASSERT_TRUE(harness_.stub->GetSession(&context_, request, &response).ok());
  EXPECT_EQ(response.session().cursor(), 42);
  ASSERT_GE(response.session().checkpoints_size(), 1);
  EXPECT_EQ(response.session().checkpoints(0), 0);
  EXPECT_EQ(response.session().build(), build_fingerprint());
}

TEST_F(Rpcs, ListComesInPages) {
  for (const char* id : {"e", "b", "d", "a", "c"}) harness_.create(id, test::wire_scene());
  v1::ListSessionsRequest request;
  request.set_page_size(2);
  std::string ids;
  int pages = 0;
  do {
    grpc::ClientContext context;
    v1::ListSessionsResponse response;
    ASSERT_TRUE(harness_.stub->ListSessions(&context, request, &response).ok());
    for (const auto& session : response.sessions()) ids += session.session_id();
    request.set_page_token(response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(ids, "abcde");
  EXPECT_EQ(pages, 3);
}

TEST_F(Rpcs, DeletingTwiceSucceeds) {
  harness_.create("s", test::wire_scene());
  v1::DeleteSessionRequest request;
  request.set_session_id("s");
  for (int i = 0; i < 2; ++i) {
    grpc::ClientContext context;
    v1::DeleteSessionResponse response;
    EXPECT_TRUE(harness_.stub->DeleteSession(&context, request, &response).ok());
  }
  v1::GetSessionRequest get;
  get.set_session_id("s");
  v1::GetSessionResponse response;
  EXPECT_EQ(harness_.stub->GetSession(&context_, get, &response).error_code(), grpc::NOT_FOUND);
}

TEST_F(Rpcs, StepSaysWhatItComputed) {
  harness_.create("s", test::wire_scene());
  EXPECT_EQ(harness_.step("s", 100).computed_steps(), 100);
  EXPECT_EQ(harness_.step("s", 100).computed_steps(), 0);
  EXPECT_EQ(harness_.step("s", 103).computed_steps(), 3);
}

TEST_F(Rpcs, ANumericalStopIsAnOutcome) {
  auto wild = test::wire_scene();
  wild.set_step(40);
  harness_.create("s", wild);
  const auto reply = harness_.step("s", 100);
  EXPECT_EQ(reply.run_status().outcome(), v1::OUTCOME_LEFT_DOMAIN);
  EXPECT_GT(reply.run_status().largest_step(), 0);
  EXPECT_LT(reply.run_status().largest_step(), 40);
  EXPECT_FALSE(reply.run_status().message().empty());
  EXPECT_LT(reply.sample().step(), 100);
  EXPECT_EQ(reply.sample().fields_size(), 2);
}

TEST_F(Rpcs, DiagnoseComparesWithStepZero) {
  harness_.create("s", test::wire_scene());
  v1::DiagnoseRequest request;
  request.set_session_id("s");
  request.set_to(1000);
  request.add_invariants("energy");
  v1::DiagnoseResponse response;
  ASSERT_TRUE(harness_.stub->Diagnose(&context_, request, &response).ok());
  EXPECT_EQ(response.run_status().outcome(), v1::OUTCOME_REACHED);
  EXPECT_EQ(response.step(), 1000);
  EXPECT_EQ(response.time(), 10.0);
  EXPECT_EQ(response.computed_steps(), 1000);
  ASSERT_EQ(response.invariants_size(), 1);
  EXPECT_EQ(response.invariants(0).name(), "energy");
  EXPECT_LT(response.invariants(0).drift(), 1e-12);
  EXPECT_LT(response.orthogonality(), 1e-13);
  EXPECT_GT(response.domain().h_omega(), 0);
}

}  // namespace
}  // namespace stiefel
