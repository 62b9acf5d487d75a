// Summaries whose streams break: every event comes once, whatever the batches of the streams.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "stiefel/client/client.h"
#include "tests/client/unreliable.h"

namespace stiefel::client {
namespace {

constexpr std::int64_t events = 12;

/// Has an event after each of the steps 0 to 11, whose field x is the step. A checkpoint is the
/// step that it is at, and comes at each multiple of the request's `checkpoint_every`.
class Breaking : public v1::SimulationService::Service {
 public:
  int breaks = 0;                   ///< so many of the next streams break
  int messages = 0;                 ///< after so many messages
  bool refuses_checkpoint = false;  ///< once
  int calls = 0;

  grpc::Status GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                          v1::GetSessionResponse* reply) override {
    v1::Session& session = *reply->mutable_session();
    session.set_session_id(request->session_id());
    session.set_system("rigid_body");
    session.set_numerics_id("mine");
    session.mutable_scene();
    session.mutable_step_price();
    return grpc::Status::OK;
  }

  grpc::Status Summarize(grpc::ServerContext* context, const v1::SummarizeRequest* request,
                         grpc::ServerWriter<v1::SummarizeResponse>* writer) override {
    const auto routed = context->client_metadata().find("stiefel-session");
    if (routed == context->client_metadata().end() || routed->second != "any")
      return {grpc::StatusCode::INVALID_ARGUMENT, "not routed"};
    if (!request->checkpoint().empty() && std::exchange(refuses_checkpoint, false))
      return refusal();
    const int size = 2 + calls++ % 3;  // of the batches of this stream
    const bool breaks_now = breaks-- > 0;
    int sent = 0;
    const auto broken = [&] { return breaks_now && sent++ == messages; };
    bool priced = false;
    const auto send = [&](v1::SummarizeResponse message) {
      if (!std::exchange(priced, true)) *message.mutable_price() = a_price();
      writer->Write(message);
    };
    std::int64_t step = request->checkpoint().empty() ? 0 : std::stoll(request->checkpoint());
    const std::int64_t every =
        request->checkpoint_every() > 0 ? request->checkpoint_every() : events;
    while (step < events) {
      const std::int64_t end = std::min({step + size, (step / every + 1) * every, events});
      if (broken()) return {grpc::StatusCode::UNAVAILABLE, "on purpose"};
      send(batch(step, end));
      step = end;
      if (step % every != 0 || step == events) continue;
      if (broken()) return {grpc::StatusCode::UNAVAILABLE, "on purpose"};
      send(checkpoint(step));
    }
    if (broken()) return {grpc::StatusCode::UNAVAILABLE, "on purpose"};
    v1::SummarizeResponse last;
    last.mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    for (const char* name : {"outcome", "last_step", "ended_by", "samples"}) {
      auto& statistic = *last.add_statistics();
      statistic.set_name(name);
      const std::int64_t number = v1::OUTCOME_REACHED;
      statistic.mutable_value()->set_data_type(v1::DATA_TYPE_INT64);
      statistic.mutable_value()->set_data(&number, sizeof number);
    }
    send(last);
    return grpc::Status::OK;
  }

 private:
  static v1::SummarizeResponse batch(std::int64_t begin, std::int64_t end) {
    v1::SummarizeResponse message;
    std::vector<double> x(static_cast<std::size_t>(end - begin));
    std::iota(x.begin(), x.end(), static_cast<double>(begin));
    for (std::int64_t step = begin; step < end; ++step) {
      message.mutable_events()->add_events(0);
      message.mutable_events()->add_steps(step);
      message.mutable_events()->add_fractions(1);
      message.mutable_events()->add_times(static_cast<double>(step + 1));
    }
    auto& field = *message.mutable_events()->add_fields();
    field.set_name("x");
    for (const std::size_t extent : {x.size(), std::size_t{1}, std::size_t{1}})
      field.mutable_value()->add_shape(extent);
    field.mutable_value()->set_data_type(v1::DATA_TYPE_FLOAT64);
    field.mutable_value()->set_data(reinterpret_cast<const char*>(x.data()),
                                    x.size() * sizeof(double));
    return message;
  }

  static v1::SummarizeResponse checkpoint(std::int64_t step) {
    v1::SummarizeResponse message;
    message.mutable_checkpoint()->set_step(step);
    message.mutable_checkpoint()->set_data(std::to_string(step));
    message.mutable_checkpoint()->set_size(message.checkpoint().data().size());
    return message;
  }

  static grpc::Status refusal() {
    v1::BadRequest bad;
    bad.add_field_violations()->set_field("checkpoint");
    v1::Status status;
    status.set_code(grpc::StatusCode::INVALID_ARGUMENT);
    auto& any = *status.add_details();
    any.set_type_url("type.googleapis.com/google.rpc.BadRequest");
    any.set_value(bad.SerializeAsString());
    return {grpc::StatusCode::INVALID_ARGUMENT, "of another build", status.SerializeAsString()};
  }
};

class BrokenSummaryTest : public testing::Test {
 protected:
  BrokenSummaryTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
  }

  /// Summarizes, and expects every event and its field once, in order.
  void expect_every_event_once(std::int64_t checkpoint_every, const Options& options = {}) {
    v1::SummarizeRequest request;
    request.set_to(events);
    request.add_events();
    request.set_checkpoint_every(checkpoint_every);
    std::vector<std::int64_t> steps;
    std::vector<double> times, x;
    const Client client(server_->InProcessChannel({}), options);
    const auto end =
        client.attach("any").summarize(request, [&](const v1::SummarizeResponse& message) {
          const auto& batch = message.events();
          steps.insert(steps.end(), batch.steps().begin(), batch.steps().end());
          times.insert(times.end(), batch.times().begin(), batch.times().end());
          for (const auto& field : batch.fields()) {
            EXPECT_EQ(field.value().shape(0), batch.steps_size());
            const auto* values = reinterpret_cast<const double*>(field.value().data().data());
            x.insert(x.end(), values, values + field.value().data().size() / sizeof(double));
          }
          return true;
        });
    EXPECT_EQ(end.run_status().outcome(), v1::OUTCOME_REACHED);
    EXPECT_EQ(end.checkpoint().data(),
              checkpoint_every == 0
                  ? ""
                  : std::to_string((events - 1) / checkpoint_every * checkpoint_every));
    std::vector<std::int64_t> expected(events);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(steps, expected);
    EXPECT_EQ(x, std::vector<double>(expected.begin(), expected.end()));
    EXPECT_EQ(times.size(), expected.size());
  }

  Breaking service_;
  std::unique_ptr<grpc::Server> server_;
};

TEST_F(BrokenSummaryTest, EveryEventComesOnce) {
  for (const std::int64_t checkpoint_every : {0, 5})
    for (int messages = 0; messages < 7; ++messages) {
      SCOPED_TRACE(messages);
      service_.breaks = 3;
      service_.messages = messages;
      service_.calls = 0;
      expect_every_event_once(checkpoint_every);
      EXPECT_GE(service_.calls, 2);
    }
}

TEST_F(BrokenSummaryTest, TheClientIsPatientAnewAfterEachCheckpoint) {
  service_.breaks = 11;
  service_.messages = 2;  // a batch and its checkpoint
  expect_every_event_once(1, {.patience = std::chrono::milliseconds(100)});
  EXPECT_EQ(service_.calls, 12);
}

TEST_F(BrokenSummaryTest, AServerThatRefusesTheCheckpointBeginsAnew) {
  service_.breaks = 1;
  service_.messages = 5;  // two or three batches, the checkpoint, and a batch or two more
  service_.refuses_checkpoint = true;
  expect_every_event_once(5);
  EXPECT_FALSE(service_.refuses_checkpoint);
  EXPECT_EQ(service_.calls, 2);
}

}  // namespace
}  // namespace stiefel::client
