// A call whose method chooses its own steps ends at its price, and the next one goes on.
#include <cmath>
#include <cstring>

#include "server/convert/errors.h"
#include "stiefel/summary.h"
#include "tests/server/flat_ellipsoid.h"
#include "tests/server/harness.h"

namespace stiefel {
namespace {

constexpr std::int64_t last_step = 400;

class Price : public testing::Test {
 protected:
  Price() {
    v1::Scene scene;
    server::to_proto(test::flat_ellipsoid(), &scene);
    harness_.create("s", scene);
    const auto motion = make_simulation(Scene::resolve(test::flat_ellipsoid()).value());
    motion->advance(last_step);
    for (const char* field : {"q", "qdot"}) {
      const RowMatrix values = motion->get(field);
      expected_.append(reinterpret_cast<const char*>(values.data()),
                       static_cast<std::size_t>(values.size()) * sizeof(double));
    }
  }

  static void expect_reached(const grpc::Status& status) {
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
    EXPECT_EQ(server::errors::reason(status).reason, "PRICE_REACHED");
    EXPECT_EQ(server::errors::retry_delay(status), std::chrono::milliseconds(1));
  }

  test::Harness harness_;
  std::string expected_;  // the bits of the state at `last_step`
};

TEST_F(Price, AStepGoesOnWhereTheOneBeforeEnded) {
  v1::StepRequest request;
  request.set_session_id("s");
  request.set_to(last_step);
  for (int calls = 0; calls < 4; ++calls) {
    grpc::ClientContext context;
    v1::StepResponse response;
    const auto status = harness_.stub->Step(&context, request, &response);
    if (!status.ok()) {
      expect_reached(status);
      continue;
    }
    EXPECT_GE(calls, 1);
    EXPECT_EQ(response.price().bound(), v1::PRICE_BOUND_AT_MOST);
    EXPECT_LT(response.computed_steps(), last_step);
    std::string bits;
    for (const auto& field : response.sample().fields()) bits += field.value().data();
    EXPECT_EQ(bits, expected_);
    return;
  }
  ADD_FAILURE() << "four calls did not reach the step";
}

TEST_F(Price, AForkAndADiagnosisEndThereToo) {
  v1::ForkSessionRequest fork;
  fork.set_session_id("t");
  fork.set_from_session_id("s");
  fork.set_from_step(last_step);
  v1::ForkSessionResponse forked;
  grpc::ClientContext fork_context;
  expect_reached(harness_.stub->ForkSession(&fork_context, fork, &forked));
  // In a session that has not yet learned what its steps take.
  v1::Scene scene;
  server::to_proto(test::flat_ellipsoid(), &scene);
  harness_.create("d", scene);
  v1::DiagnoseRequest diagnose;
  diagnose.set_session_id("d");
  diagnose.set_to(last_step);
  v1::DiagnoseResponse diagnosis;
  grpc::ClientContext context;
  expect_reached(harness_.stub->Diagnose(&context, diagnose, &diagnosis));
}

/// The statistics of the flat ellipsoid up to `last_step`, without a server.
std::vector<SummaryArray> expected_statistics(Statistic statistic) {
  const Scene scene = Scene::resolve(test::flat_ellipsoid()).value();
  auto summary = Summary::prepare(scene, {.to = last_step,
                                          .quantities = {{.name = "q", .statistics = {statistic}}}})
                     .value();
  while (!summary.done()) summary.advance(last_step, last_step);
  return summary.statistics();
}

TEST_F(Price, ASummaryEndsWithACheckpointAndGoesOnFromIt) {
  v1::SummarizeRequest request;
  request.set_session_id("s");
  request.set_to(last_step);
  v1::Quantity& quantity = *request.add_quantities();
  quantity.set_name("q");
  quantity.add_statistics(v1::STATISTIC_MEAN);
  for (int calls = 0; calls < 4; ++calls) {
    grpc::ClientContext context;
    const auto reader = harness_.stub->Summarize(&context, request);
    v1::SummarizeResponse message;
    std::string checkpoint, mean;
    while (reader->Read(&message)) {
      checkpoint += message.checkpoint().data();
      if (message.statistics_size() > 0) mean += message.statistics(0).value().data();
    }
    const auto status = reader->Finish();
    if (!status.ok()) {
      expect_reached(status);
      ASSERT_FALSE(checkpoint.empty());
      request.set_checkpoint(checkpoint);
      continue;
    }
    EXPECT_GE(calls, 1);
    const std::vector<double> expected = expected_statistics(Statistic::mean).front().numbers;
    ASSERT_EQ(mean.size(), expected.size() * sizeof(double));
    EXPECT_EQ(std::memcmp(mean.data(), expected.data(), mean.size()), 0);
    return;
  }
  ADD_FAILURE() << "four calls did not reach the step";
}

/// Calls `method` with the request and returns the first message and the status.
template <class Method, class Request, class Response>
grpc::Status first(test::Harness& harness, Method method, const Request& request,
                   Response& response) {
  grpc::ClientContext context;
  const auto reader = ((*harness.stub).*method)(&context, request);
  const bool came = reader->Read(&response);
  if (came) context.TryCancel();
  const grpc::Status status = reader->Finish();
  return came ? grpc::Status::OK : status;
}

/// The bytes that a refused call asked for.
std::uint64_t asked(const grpc::Status& status) {
  v1::Status details;
  EXPECT_TRUE(details.ParseFromString(status.error_details()));
  v1::ErrorInfo info;
  for (const auto& any : details.details())
    if (any.type_url().ends_with("ErrorInfo")) {
      EXPECT_TRUE(info.ParseFromString(any.value()));
    }
  EXPECT_EQ(info.reason(), "MEMORY_LIMIT") << status.error_message();
  return info.metadata().contains("bytes") ? std::stoull(info.metadata().at("bytes")) : 0;
}

/// The memory in the price of a call is what a server without so much refuses it for.
class MemoryPrice : public testing::Test {
 protected:
  template <class Method, class Request, class Response>
  void expect_asked(Method method, const Request& request, Response response,
                    const v1::Price& (*price)(const Response&)) {
    const auto status = first(large_, method, request, response);
    ASSERT_TRUE(status.ok()) << status.error_message();
    Response none;
    EXPECT_EQ(price(response).memory_bytes(), asked(first(small_, method, request, none)));
  }

  const v1::Scene scene_ = test::wire_scene({.method = "rk4", .dimension = 150});
  test::Harness large_{{.threads = 2, .memory = std::uint64_t{4} << 30}};
  test::Harness small_{{.threads = 2, .memory = std::uint64_t{64} << 20}};
};

TEST_F(MemoryPrice, OfAConversion) {
  v1::ConvertRequest request;
  *request.mutable_scene() = test::wire_scene({.method = "rk4", .dimension = 260});
  request.set_to("velocity");
  expect_asked(
      &v1::SimulationService::Stub::Convert, request, v1::ConvertResponse(),
      +[](const v1::ConvertResponse& r) -> const v1::Price& { return r.price(); });
}

/// More than the 32 KiB of any call.
TEST_F(MemoryPrice, OfSearches) {
  constexpr std::uint64_t call = 32 << 10;
  v1::MeasureTradeoffRequest measure;
  v1::Scene& scene = *measure.mutable_scene();
  scene.set_system("rigid_body");
  scene.set_step(0.05);
  scene.mutable_method()->set_name("variational");
  for (const double I : {1., 2., 3.}) scene.mutable_body()->add_moments(I);
  for (const double w : {0.1, 1., 0.2}) scene.mutable_body()->add_angular_velocity(w);
  measure.set_horizon(0.5);
  measure.set_budget(3e8);
  measure.set_repeats(1);
  v1::MeasureTradeoffResponse measured;
  ASSERT_TRUE(first(large_, &v1::SimulationService::Stub::MeasureTradeoff, measure, measured).ok());
  EXPECT_GT(measured.setup().price().memory_bytes(), call);
  v1::ConnectRequest connect;
  auto& pair = *connect.add_pairs();
  for (const bool last : {false, true}) {
    v1::Matrix& frame = last ? *pair.mutable_q_t() : *pair.mutable_q_0();
    frame.set_rows(1);
    frame.set_cols(3);
    for (const double x : {last ? 0. : 1., last ? 1. : 0., 0.}) frame.add_values(x);
  }
  for (const double lambda : {1., 2., 3.}) connect.add_inertia(lambda);
  connect.set_time(1);
  v1::ConnectResponse joined;
  ASSERT_TRUE(first(large_, &v1::SimulationService::Stub::Connect, connect, joined).ok());
  EXPECT_GT(joined.price().memory_bytes(), call);
}

/// A Summarize takes a simulation, of 34 N² numbers for rk4, and 32 bytes for each time.
TEST_F(MemoryPrice, OfASummary) {
  large_.create("s", scene_);
  v1::SummarizeRequest request;
  request.set_session_id("s");
  request.set_to(1000);
  for (int i = 0; i <= 100; ++i) request.add_times(0);
  v1::SummarizeResponse response;
  const auto status = first(large_, &v1::SimulationService::Stub::Summarize, request, response);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_GE(response.price().memory_bytes(), 34 * 150 * 150 * 8 + 32 * 101);
}

/// What is read at every step is in the price: N⁵/2 products of numbers for Manakov's coefficients,
/// which take more than an instruction each.
TEST_F(MemoryPrice, AndWorkOfWhatASummaryReads) {
  constexpr double N = 12, samples = 101;
  large_.create("s", test::wire_scene({.method = "rk4", .dimension = 12}));
  const auto work = [&](const char* quantity, v1::Statistic statistic) {
    v1::SummarizeRequest request;
    request.set_session_id("s");
    request.set_to(100);
    auto& one = *request.add_quantities();
    one.set_name(quantity);
    one.add_statistics(statistic);
    v1::SummarizeResponse response;
    EXPECT_TRUE(first(large_, &v1::SimulationService::Stub::Summarize, request, response).ok());
    return response.price().work();
  };
  const double block = work("Q", v1::STATISTIC_MEAN);
  const double each = (work("manakov", v1::STATISTIC_MEAN) - block) / samples;
  EXPECT_GT(each, N * N * N * N * N / 2);
  EXPECT_LT(each, 100 * N * N * N * N * N);
  EXPECT_NEAR(work("manakov", v1::STATISTIC_LAST) - block, each, each) << "read once";
}

}  // namespace
}  // namespace stiefel
