// Callers who leave while the simulation of an ensemble is made: each is answered, and nothing
// stays behind.
#include <thread>

#include "tests/server/harness.h"

namespace stiefel {
namespace {

using namespace std::chrono_literals;

v1::Scene bodies(std::uint32_t members) {
  v1::Scene scene = test::wire_scene();
  scene.clear_initial();
  scene.clear_inertia();
  for (const double moment : {1.0, 2.0, 2.5}) scene.mutable_body()->add_moments(moment);
  for (std::uint32_t b = 0; b < 3 * members; ++b)
    scene.mutable_body()->add_angular_velocity(0.3 + 1e-4 * b);
  scene.set_members(members);
  return scene;
}

/// Cancels `call(stub, context)` of the session "s" of 2000 bodies 0 to 9.5 ms after its begin. The
/// call returns its status.
template <class Call>
void cancel_while_the_ensemble_is_made(Call call) {
  test::Harness harness({.threads = 2});
  harness.create("s", bodies(2000));
  int cancelled = 0;
  for (int i = 0; i < 40; ++i) {
    grpc::ClientContext context;
    const std::jthread leaves([&context, i] {
      std::this_thread::sleep_for(i % 20 * 500us);
      context.TryCancel();
    });
    const auto code = call(*harness.stub, context).error_code();
    cancelled += code == grpc::CANCELLED;
    EXPECT_TRUE(code == grpc::CANCELLED || code == grpc::OK) << code;
  }
  EXPECT_GT(cancelled, 0);
  const auto reached = harness.step("s", 3);
  EXPECT_EQ(reached.sample().step(), 3);
}

using Stub = v1::SimulationService::StubInterface;

TEST(Cancel, OfAFork) {
  cancel_while_the_ensemble_is_made([](Stub& stub, grpc::ClientContext& context) {
    v1::ForkSessionRequest request;
    request.set_session_id("t");
    request.set_from_session_id("s");
    v1::ForkSessionResponse response;
    return stub.ForkSession(&context, request, &response);
  });
}

TEST(Cancel, OfASummary) {
  cancel_while_the_ensemble_is_made([](Stub& stub, grpc::ClientContext& context) {
    v1::SummarizeRequest request;
    request.set_session_id("s");
    request.set_to(2);
    v1::Quantity& quantity = *request.add_quantities();
    quantity.set_name("energy");
    quantity.add_statistics(v1::STATISTIC_DRIFT);
    const auto reader = stub.Summarize(&context, request);
    v1::SummarizeResponse message;
    while (reader->Read(&message)) {
    }
    return reader->Finish();
  });
}

TEST(Cancel, OfADrive) {
  cancel_while_the_ensemble_is_made([](Stub& stub, grpc::ClientContext& context) {
    const auto drive = stub.Drive(&context);
    v1::DriveRequest request;
    request.set_session_id("s");
    request.set_to(2);
    v1::DriveResponse response;
    if (drive->Write(request)) drive->Read(&response);
    drive->WritesDone();
    return drive->Finish();
  });
}

}  // namespace
}  // namespace stiefel
