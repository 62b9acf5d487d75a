#include "stiefel/client/recreation.h"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <array>
#include <optional>

#include "client/cpp/uuid.h"
#include "server/server.h"
#include "stiefel/client/client.h"
#include "tests/client/unreliable.h"
#include "tests/client/wire_scenes.h"

namespace stiefel::client {
namespace {

std::string bytes(const v1::Sample& sample) {
  std::string all;
  for (const auto& field : sample.fields()) all += field.value().data();
  return all;
}

template <class Call>
std::string reason_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.reason();
  }
  return "no error";
}

/// A server that loses its sessions whenever it is replaced, at one address.
class RecreationTest : public testing::Test {
 protected:
  RecreationTest() { replace(); }

  void replace() {
    server_.reset();
    server_.emplace(server::Options{.listen = {address_}, .threads = 1, .log_level = "off"});
  }
  std::size_t sessions() const { return Client::connect(address_).list().size(); }

  const std::string address_ = "unix:" + testing::TempDir() + "stiefel_" + make_uuid();
  std::optional<server::Server> server_;
  Client client_ = Client::connect(address_);
};

TEST_F(RecreationTest, EveryCallGoesOnAtAServerThatLostTheSession) {
  const auto session = client_.create(tumbling());
  const std::string expected = bytes(session.step(300).sample());
  auto drive = session.drive();
  EXPECT_EQ(bytes(drive.step(300).sample()), expected);
  const auto drift = session.diagnose(300).invariants(0).drift();
  v1::SummarizeRequest of_energy;
  of_energy.set_to(300);
  of_energy.add_quantities()->set_name("energy");
  of_energy.mutable_quantities(0)->add_statistics(v1::STATISTIC_DRIFT);
  const auto drifted = [&] { return session.summarize(of_energy).statistics(0).value().data(); };
  const std::string largest = drifted();
  v1::ForkSessionRequest at;
  at.set_from_step(300);
  at.set_step(0.02);
  const auto fork = session.fork(at);
  const std::string forked = bytes(fork.step(10).sample());

  replace();
  EXPECT_EQ(bytes(session.step(300).sample()), expected);
  replace();
  EXPECT_EQ(bytes(drive.step(300).sample()), expected);
  replace();
  EXPECT_EQ(session.diagnose(300).invariants(0).drift(), drift);
  replace();
  EXPECT_EQ(drifted(), largest);
  replace();
  EXPECT_EQ(bytes(session.fork(at).step(10).sample()), forked);
  replace();
  EXPECT_EQ(bytes(fork.step(10).sample()), forked) << "whose parent is not there";
  replace();
  EXPECT_EQ(session.refresh().session_id(), session.id());
  replace();
  auto stream = session.stream({.from = 300, .to = 300});
  const auto* batch = stream.next_batch();
  ASSERT_TRUE(batch);
  EXPECT_EQ(batch->steps(0), 300);
  EXPECT_EQ(batch->fields(0).value().data(), expected.substr(0, 4 * sizeof(double)));
}

TEST_F(RecreationTest, ItGoesOnFromTheLastCheckpoint) {
  const auto session = client_.create(tumbling());
  EXPECT_FALSE(session.checkpoint(5000).checkpoint().empty());
  replace();
  EXPECT_EQ(session.step(5001).computed_steps(), 1);

  const auto other = client_.create(tumbling(), "", session.checkpoint(7000).checkpoint());
  replace();
  EXPECT_EQ(other.step(7001).computed_steps(), 1) << "with which it was created";
}

TEST_F(RecreationTest, ItGoesBackFromAnEarlierCheckpoint) {
  const auto checkpoint = client_.create(tumbling()).checkpoint(5000).checkpoint();
  const auto session = client_.create(tumbling(), "", checkpoint);
  session.checkpoint(7000);
  replace();
  EXPECT_EQ(session.step(5002).computed_steps(), 2) << "from the one that it was created with";
  EXPECT_EQ(session.step(7001).computed_steps(), 1) << "from the last one";

  const auto other = client_.create(tumbling());
  for (const std::int64_t step : {9000, 8000, 9500}) other.checkpoint(step);
  replace();
  auto drive = other.drive();
  EXPECT_EQ(drive.step(8003).computed_steps(), 3);
  EXPECT_EQ(drive.step(9501).computed_steps(), 1);
}

TEST_F(RecreationTest, OnlyTheHandleThatCreatedItCreatesItAgain) {
  const auto session = client_.create(tumbling());
  const auto found = client_.attach(session.id());
  replace();
  EXPECT_EQ(reason_of([&] { found.step(1); }), "SESSION_NOT_FOUND");
  auto drive = found.drive();
  EXPECT_EQ(reason_of([&] { drive.step(1); }), "SESSION_NOT_FOUND");
  EXPECT_EQ(sessions(), 0u);
  session.step(1);
  EXPECT_EQ(drive.step(1).sample().step(), 1) << "the drive is still open";
}

TEST_F(RecreationTest, ADeletedSessionStaysDeleted) {
  const auto session = client_.create(tumbling());
  auto drive = session.drive();
  drive.step(1);
  Client::connect(address_).remove(session.id());
  EXPECT_EQ(reason_of([&] { session.step(1); }), "SESSION_DELETED");
  EXPECT_EQ(reason_of([&] { drive.step(1); }), "SESSION_DELETED");
  v1::ForkSessionRequest at;
  EXPECT_EQ(reason_of([&] { session.fork(at); }), "SESSION_DELETED");
  EXPECT_EQ(sessions(), 0u);
}

TEST_F(RecreationTest, AHandleThatIsGoneCreatesNothing) {
  std::optional<Drive> open, broken;
  {
    const auto session = client_.create(tumbling());
    open.emplace(session.drive());
    broken.emplace(session.drive());
    open->step(1);
    broken->step(1);
    replace();
    open->step(1);
  }
  EXPECT_EQ(reason_of([&] { open->step(1); }), "SESSION_DELETED");
  EXPECT_EQ(reason_of([&] { broken->step(1); }), "SESSION_DELETED");
  EXPECT_EQ(sessions(), 0u);
}

TEST_F(RecreationTest, WithoutAServerItEnds) {
  Options options;
  options.patience = std::chrono::milliseconds(60);
  const auto session = Client::connect(address_, options).create(tumbling());
  server_.reset();
  try {
    session.step(1);
    ADD_FAILURE() << "no server answered";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::UNAVAILABLE);
  }
}

TEST_F(RecreationTest, CheckpointsComeAboutEverySecondOfWork) {
  v1::Session described;
  described.mutable_step_price()->set_work(1e9);
  Recreation handle(nullptr, described, [] { return v1::Scene(); });
  EXPECT_EQ(handle.checkpoint_every(), 5);
  EXPECT_FALSE(handle.wants_checkpoint(4));
  EXPECT_TRUE(handle.wants_checkpoint(5));
  handle.keep({.step = 50, .bytes = "state"});
  EXPECT_FALSE(handle.wants_checkpoint(54));
  EXPECT_TRUE(handle.wants_checkpoint(55));
  EXPECT_TRUE(handle.wants_checkpoint(49)) << "that of step 50 does not help there";
  EXPECT_FALSE(handle.wants_checkpoint(4)) << "step 0 is near";
  EXPECT_EQ(Recreation(nullptr, described, nullptr).checkpoint_every(), 0) << "creates nothing";
}

/// Answers for every session, with the numerics id "other", and keeps what calls say beside their
/// message.
class OtherBuild : public v1::SimulationService::Service {
 public:
  std::vector<std::string> routed;

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::CreateSessionResponse* reply) override {
    answer(context);
    if (!request->checkpoint().empty()) return refusal();
    reply->mutable_session()->set_session_id(request->session_id());
    return grpc::Status::OK;
  }
  grpc::Status Step(grpc::ServerContext* context, const v1::StepRequest* request,
                    v1::StepResponse* reply) override {
    answer(context);
    reply->mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    *reply->mutable_price() = a_price();
    reply->mutable_sample()->set_step(request->to());
    *reply->mutable_sample()->add_fields() = field_x(std::array{request->to()}, false);
    if (request->return_checkpoint()) reply->set_checkpoint("of the other build");
    return grpc::Status::OK;
  }
  grpc::Status Stream(grpc::ServerContext* context, const v1::StreamRequest* request,
                      grpc::ServerWriter<v1::StreamResponse>* writer) override {
    answer(context);
    v1::StreamResponse message;
    message.add_steps(request->to());
    message.add_times(0);
    message.mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    writer->Write(message);
    return grpc::Status::OK;
  }

 private:
  void answer(grpc::ServerContext* context) {
    context->AddInitialMetadata("stiefel-numerics-id", "other");
    const auto found = context->client_metadata().find("stiefel-session");
    routed.push_back(found == context->client_metadata().end()
                         ? ""
                         : std::string(found->second.data(), found->second.size()));
  }
  static grpc::Status refusal() {
    v1::ErrorInfo info;
    info.set_reason("CHECKPOINT_OF_OTHER_NUMERICS");
    (*info.mutable_metadata())["server_numerics_id"] = "other";
    v1::Status status;
    auto& any = *status.add_details();
    any.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
    any.set_value(info.SerializeAsString());
    return {grpc::StatusCode::FAILED_PRECONDITION, "other", status.SerializeAsString()};
  }
};

class OtherBuildTest : public RecreationTest {
 protected:
  void SetUp() override {
    session_.emplace(
        Client::connect(address_, {.any_build = any_build()}).create(tumbling(), "mine"));
    session_->checkpoint(10);
    server_.reset();
    grpc::ServerBuilder builder;
    builder.AddListeningPort(address_, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    other_ = builder.BuildAndStart();
  }
  virtual bool any_build() const { return false; }
  void TearDown() override { session_.reset(); }

  OtherBuild service_;
  std::unique_ptr<grpc::Server> other_;
  std::optional<Session> session_;
};

TEST_F(OtherBuildTest, IsNotGoneOnAtSilently) {
  EXPECT_THROW(session_->step(11), BuildChanged);
  auto stream = session_->stream({.from = 11, .to = 11});
  EXPECT_THROW(stream.next_batch(), BuildChanged);
  try {
    session_->step(11);
  } catch (const BuildChanged& changed) {
    EXPECT_EQ(changed.began_with(), session_->description().numerics_id());
    EXPECT_EQ(changed.now(), "other");
    EXPECT_EQ(changed.reason(), "BUILD_CHANGED");
  }
  ASSERT_FALSE(service_.routed.empty());
  for (const auto& by : service_.routed) EXPECT_EQ(by, "mine");
}

class AnyBuildTest : public OtherBuildTest {
 protected:
  bool any_build() const override { return true; }
};

TEST_F(AnyBuildTest, IsGoneOnAtOnRequest) { EXPECT_EQ(session_->step(11).sample().step(), 11); }

TEST_F(RecreationTest, ANameThatNoServerTakesIsNotRouted) {
  try {
    client_.attach("no\nname");
    ADD_FAILURE() << "there is no such session";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), grpc::StatusCode::INVALID_ARGUMENT) << error.what();
  }
}

TEST(AsUnavailable, IsAConnectionThatBroke) {
  using enum grpc::StatusCode;
  const auto seen = [](grpc::StatusCode code, const std::string& message,
                       std::string details = "") {
    return as_unavailable(grpc::Status(code, message, std::move(details))).error_code();
  };
  EXPECT_EQ(seen(CANCELLED, "Received RST_STREAM with error code 8"), UNAVAILABLE);
  EXPECT_EQ(seen(UNKNOWN, "Stream removed"), UNAVAILABLE);
  EXPECT_EQ(seen(CANCELLED, "CANCELLED"), UNAVAILABLE) << "by a server at its end";
  EXPECT_EQ(seen(CANCELLED, "Received RST_STREAM", "details"), CANCELLED) << "by the server";
  EXPECT_EQ(seen(RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11"), RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace stiefel::client
