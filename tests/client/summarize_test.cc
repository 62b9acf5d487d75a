#include <gmock/gmock.h>

#include <map>

#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

class SummarizeTest : public testing::Test {
 protected:
  server::Server server_{{.listen = {"127.0.0.1:0"}, .threads = 1, .log_level = "off"}};
  Client client_{server_.in_process_channel()};
};

v1::SummarizeRequest request_to(std::int64_t to) {
  v1::SummarizeRequest request;
  request.set_to(to);
  auto* energy = request.add_quantities();
  energy->set_name("energy");
  energy->add_statistics(v1::STATISTIC_DRIFT);
  auto* M = request.add_quantities();
  M->set_name("M");
  M->add_statistics(v1::STATISTIC_LAST);
  M->add_quantiles(0.5);
  return request;
}

std::map<std::string, std::string> bytes(const v1::SummarizeResponse& end) {
  std::map<std::string, std::string> all;
  for (const auto& field : end.statistics()) all[field.name()] = field.value().data();
  return all;
}

TEST_F(SummarizeTest, TheLastValueIsThatOfTheLastStep) {
  const auto session = client_.create(tumbling());
  const auto end = session.summarize(request_to(1000));
  EXPECT_EQ(end.run_status().outcome(), v1::OUTCOME_REACHED);
  EXPECT_EQ(bytes(end)["M.last"], session.step(1000, {"M"}).sample().fields(0).value().data());
  EXPECT_GT(end.price().work(), 0);
}

TEST_F(SummarizeTest, ACheckpointGoesOnWithTheSameBytes) {
  const auto session = client_.create(tumbling());
  auto request = request_to(1000);
  const auto whole = session.summarize(request);
  request.set_checkpoint_every(300);
  std::vector<std::string> checkpoints;
  session.summarize(request, [&](const v1::SummarizeResponse& message) {
    if (message.has_checkpoint()) checkpoints.push_back(message.checkpoint().data());
    return true;
  });
  ASSERT_EQ(checkpoints.size(), 3);
  request.set_checkpoint_every(0);
  for (const std::string& checkpoint : checkpoints) {
    request.set_checkpoint(checkpoint);
    const auto other = client_.create(tumbling());
    EXPECT_EQ(bytes(other.summarize(request)), bytes(whole));
  }
}

TEST_F(SummarizeTest, TheReceiverEndsTheCall) {
  const auto session = client_.create(tumbling());
  auto request = request_to(std::int64_t{1} << 40);
  request.clear_quantities();
  auto* event = request.add_events();
  event->set_field("M");
  for (int i = 0; i < 9; ++i) event->add_coefficients(i == 1 ? 1 : 0);
  int events = 0;
  session.summarize(request, [&](const v1::SummarizeResponse& message) {
    events += message.events().steps_size();
    return events < 10;
  });
  EXPECT_GE(events, 10);
  EXPECT_EQ(session.step(5).sample().step(), 5);
}

TEST_F(SummarizeTest, AWrongRequestIsAnError) {
  const auto session = client_.create(tumbling());
  auto request = request_to(10);
  request.mutable_quantities(1)->set_name("nothing");
  try {
    session.summarize(request);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT);
    ASSERT_FALSE(error.violations().empty());
    EXPECT_EQ(error.violations()[0].field, "quantities[1].name");
  }
}

}  // namespace
}  // namespace stiefel::client
