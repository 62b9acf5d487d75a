// The arrays of a scene that are too large for a reply, where the server loses the session before
// they have come.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/client.h"
#include "stiefel/v1/error.pb.h"

namespace stiefel::client {
namespace {

/// Every session has an array that is left out of its scene: `inertia`, 3 2 1. The next `losses`
/// streams find that their session is gone. `calls` is what was asked for, and of which session.
class Forgetful : public v1::SimulationService::Service {
 public:
  int losses = 0;
  std::string numerics;
  std::vector<std::string> calls;

  grpc::Status CreateSession(grpc::ServerContext*, const v1::CreateSessionRequest* request,
                             v1::CreateSessionResponse* reply) override {
    calls.push_back("create " + request->session_id());
    describe(request->session_id(), reply->mutable_session());
    return grpc::Status::OK;
  }
  grpc::Status ForkSession(grpc::ServerContext*, const v1::ForkSessionRequest* request,
                           v1::ForkSessionResponse* reply) override {
    calls.push_back("fork " + request->session_id());
    describe(request->session_id(), reply->mutable_session());
    reply->mutable_run_status()->set_outcome(v1::OUTCOME_REACHED);
    return grpc::Status::OK;
  }
  grpc::Status Stream(grpc::ServerContext* context, const v1::StreamRequest* request,
                      grpc::ServerWriter<v1::StreamResponse>* writer) override {
    calls.push_back("stream " + request->session_id());
    if (!numerics.empty()) context->AddInitialMetadata("stiefel-numerics-id", numerics);
    if (losses-- > 0) return gone(request->session_id());
    v1::StreamResponse message;
    auto& array = *message.add_scene_arrays();
    array.set_name("inertia");
    array.mutable_value()->add_shape(3);
    array.mutable_value()->set_data_type(v1::DATA_TYPE_FLOAT64);
    const double numbers[] = {3, 2, 1};
    array.mutable_value()->set_data(numbers, sizeof numbers);
    writer->Write(message);
    message.Clear();
    message.add_steps(0);
    writer->Write(message);
    return grpc::Status::OK;
  }
  grpc::Status DeleteSession(grpc::ServerContext*, const v1::DeleteSessionRequest*,
                             v1::DeleteSessionResponse*) override {
    return grpc::Status::OK;
  }

 private:
  static void describe(const std::string& id, v1::Session* session) {
    session->set_session_id(id);
    session->set_system("rigid_body");
    session->set_numerics_id("mine");
    session->mutable_scene();
    session->mutable_step_price();
    session->add_left_out("inertia");
  }
  static grpc::Status gone(const std::string& id) {
    v1::ErrorInfo info;
    info.set_reason("SESSION_NOT_FOUND");
    (*info.mutable_metadata())["session_id"] = id;
    v1::Status status;
    auto& any = *status.add_details();
    any.set_type_url("type.googleapis.com/google.rpc.ErrorInfo");
    any.set_value(info.SerializeAsString());
    return {grpc::StatusCode::NOT_FOUND, "gone", status.SerializeAsString()};
  }
};

class LostArraysTest : public testing::Test {
 protected:
  LostArraysTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
  }
  Client client() { return Client(server_->InProcessChannel({})); }

  Forgetful service_;
  std::unique_ptr<grpc::Server> server_;
};

using Calls = std::vector<std::string>;

TEST_F(LostArraysTest, TheSessionIsCreatedAgain) {
  const auto session = client().create({}, "a");
  service_.losses = 2;
  EXPECT_EQ(session.scene().inertia_size(), 3);
  EXPECT_EQ(service_.calls,
            (Calls{"create a", "stream a", "create a", "stream a", "create a", "stream a"}));
}

/// Its handle does not know the scene with which it could create the fork.
TEST_F(LostArraysTest, AForkIsMadeAgain) {
  const auto session = client().create({}, "a");
  session.scene();
  service_.calls.clear();
  service_.losses = 2;
  v1::ForkSessionRequest request;
  request.set_session_id("b");
  const auto fork = session.fork(request);
  EXPECT_EQ(fork.scene().inertia_size(), 3);
  EXPECT_EQ(service_.calls,
            (Calls{"fork b", "stream b", "fork b", "stream b", "fork b", "stream b"}));
}

TEST_F(LostArraysTest, ThoseOfAnotherBuildAreNotTaken) {
  const auto session = client().create({}, "a");
  service_.numerics = "other";
  EXPECT_THROW(session.scene(), BuildChanged);
  service_.losses = 1;
  EXPECT_THROW(session.scene(), BuildChanged);
  EXPECT_EQ(service_.calls, (Calls{"create a", "stream a", "stream a"}));
}

}  // namespace
}  // namespace stiefel::client
