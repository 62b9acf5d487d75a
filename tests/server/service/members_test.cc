// Calls on ensembles: a tolerance, a conversion, a trade-off.
#include "stiefel/tradeoff.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

/// Bodies that start alike and spin at 1, 2, ... times the same rate.
v1::Scene ensemble(std::uint32_t members) {
  v1::Scene scene = test::wire_scene();
  for (auto& [name, block] : *scene.mutable_initial()) {
    const google::protobuf::RepeatedField<double> one = block.values();
    for (std::uint32_t b = 1; b < members; ++b)
      for (const double x : one) block.add_values(name == "M" ? (b + 1) * x : x);
    block.set_rows(members * block.rows());
  }
  scene.set_members(members);
  return scene;
}

TEST(Members, ShareAChoice) {
  test::Harness harness;
  v1::Scene scene = ensemble(3);
  scene.clear_method();
  scene.set_tolerance(1e-8);
  scene.set_horizon(1);
  const auto reply = harness.create("s", scene);
  EXPECT_EQ(reply.price().work(), Choice::most_work);
  EXPECT_NE(reply.session().choice().reason().find("3 members"), std::string::npos)
      << reply.session().choice().reason();
  EXPECT_EQ(reply.session().choice().tolerance(), 1e-8);
  EXPECT_FALSE(reply.session().scene().has_tolerance());
}

/// Geodesics on V(1, 4) without a method.
v1::Scene points(std::uint32_t members) {
  v1::Scene scene;
  scene.set_system("stiefel");
  scene.set_step(0.1);
  scene.set_members(members);
  for (const double lambda : {1.0, 2.0, 3.0, 4.0}) scene.add_inertia(lambda);
  for (const auto& [name, row] : {std::pair{"Q", 0}, std::pair{"S", 1}}) {
    v1::Matrix& block = (*scene.mutable_initial())[name];
    block.set_rows(members);
    block.set_cols(4);
    for (std::uint32_t b = 0; b < members; ++b)
      for (int j = 0; j < 4; ++j) block.add_values(j == row ? 1 : 0);
  }
  return scene;
}

TEST(Members, WithoutAMethodPayForItsSubsteps) {
  test::Harness harness;
  const auto work = [&](const std::string& id, std::uint32_t members) {
    const auto reply = harness.create(id, points(members));
    EXPECT_EQ(reply.price().bound(), v1::PRICE_BOUND_AT_MOST);
    EXPECT_EQ(reply.session().scene().method().name(), "variational");
    return reply.price().work();
  };
  const double one = work("one", 1);
  EXPECT_GT(one, 1e5);
  EXPECT_LT(one, 1e7);
  EXPECT_DOUBLE_EQ(work("many", 500), 500 * one);
  v1::Scene with = points(2);
  with.mutable_method()->set_name("rk4");
  EXPECT_FALSE(harness.create("with", with).has_price());
}

TEST(Members, AreConvertedOneByOne) {
  test::Harness harness;
  v1::ConvertRequest request;
  *request.mutable_scene() = ensemble(3);
  request.set_to("velocity");
  grpc::Status status;
  auto replies = harness.convert(request, &status);
  ASSERT_TRUE(status.ok()) << status.error_message();
  const double work_of_three = replies.front().price().work();
  for (const auto& block : replies.front().blocks()) {
    ASSERT_EQ(block.value().shape_size(), 3) << block.name();
    EXPECT_EQ(block.value().shape(0), 3u);
    EXPECT_EQ(block.value().shape(1), 3u);
  }
  *request.mutable_scene() = ensemble(6);
  EXPECT_EQ(harness.convert(request, &status).front().price().work(), 2 * work_of_three);

  request.set_to("symmetric_rigid_body");
  request.set_view(v1::SCENE_VIEW_FULL);
  replies = harness.convert(request, &status);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(replies.front().scene().members(), 6u);
  EXPECT_EQ(replies.front().scene().initial().at("Q").rows(), 18u);
}

TEST(Members, OutsideADomainAreNamed) {
  test::Harness harness;
  v1::ConvertRequest request;
  *request.mutable_scene() = ensemble(3);
  double norm = 0;
  for (const double x : request.scene().initial().at("M").values()) norm = std::max(norm, x);
  request.set_to("symmetric_rigid_body");
  request.set_epsilon(100 / norm);
  grpc::Status status;
  EXPECT_TRUE(harness.convert(request, &status).empty());
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message().find("epsilon: member "), 0u) << status.error_message();
  EXPECT_NE(status.error_message().find("outside the domain S_M"), std::string::npos);
  v1::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  bool named = false;
  for (const auto& any : details.details()) {
    v1::ErrorInfo info;
    if (any.type_url() != "type.googleapis.com/google.rpc.ErrorInfo") continue;
    ASSERT_TRUE(info.ParseFromString(any.value()));
    named = info.metadata().contains("member");
  }
  EXPECT_TRUE(named);
}

TEST(Members, AreMeasuredTogether) {
  test::Harness harness;
  v1::MeasureTradeoffRequest request;
  *request.mutable_scene() = ensemble(3);
  request.set_horizon(0.1);
  request.set_budget(3e8);
  request.set_repeats(1);
  grpc::ClientContext context;
  const auto reader = harness.stub->MeasureTradeoff(&context, request);
  v1::MeasureTradeoffResponse part;
  int points = 0;
  while (reader->Read(&part)) points += part.has_point();
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_GT(points, 10);
}

}  // namespace
}  // namespace stiefel
