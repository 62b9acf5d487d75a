#include <fstream>

#include "tests/server/harness.h"
#include "tests/support/sanitizer.h"

namespace stiefel {
namespace {

v1::StreamRequest range(std::int64_t from, std::int64_t to, std::int64_t every) {
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_from(from);
  request.set_to(to);
  request.set_every(every);
  return request;
}

std::int64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * 4096;
}

TEST(Streams, ResumeWhereTheyBroke) {
  test::Harness harness;
  harness.create("s", test::wire_scene());
  std::string whole, halves;
  const auto collect = [&](const v1::StreamRequest& request, std::string& into) {
    grpc::ClientContext context;
    const auto stream = harness.stub->Stream(&context, request);
    v1::StreamResponse message;
    while (stream->Read(&message)) into += message.fields(0).value().data();
    EXPECT_TRUE(stream->Finish().ok());
  };
  collect(range(0, 9000, 3), whole);
  collect(range(0, 4500, 3), halves);
  collect(range(4503, 9000, 3), halves);
  EXPECT_EQ(whole, halves);
}

TEST(Streams, ALargeSampleTravelsAlone) {
  test::Harness harness;
  v1::Scene scene = test::wire_scene({.method = "rk4", .dimension = 200});
  scene.set_step(1e-6);  // in longer steps rk4 diverges here
  harness.create("s", scene);
  grpc::ClientContext context;
  const auto stream = harness.stub->Stream(&context, range(0, 2, 1));
  v1::StreamResponse message;
  for (std::int64_t step = 0; step <= 2; ++step) {
    ASSERT_TRUE(stream->Read(&message));
    ASSERT_EQ(message.steps_size(), 1);
    EXPECT_EQ(message.steps(0), step);
  }
  EXPECT_EQ(message.run_status().outcome(), v1::OUTCOME_REACHED);
}

TEST(Streams, NobodyReads) {
  test::Harness harness;
  harness.create("s", test::wire_scene());
  constexpr int count = 100;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::StreamResponse>>> streams;
  const std::int64_t before = resident_bytes();
  for (int i = 0; i < count; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    streams.push_back(harness.stub->Stream(contexts.back().get(), range(0, 1'000'000'000, 1)));
  }
  // Others are served meanwhile, on the same threads.
  for (int i = 1; i <= 50; ++i) {
    EXPECT_EQ(harness.step("s", i * 10'000).sample().step(), i * 10'000);
  }
  v1::StreamResponse message;
  for (auto& stream : streams) EXPECT_TRUE(stream->Read(&message));
  if (!stiefel::testing::sanitized) {
    EXPECT_LT(resident_bytes() - before, 100'000'000);
  }
  for (auto& context : contexts) context->TryCancel();
  for (auto& stream : streams) EXPECT_EQ(stream->Finish().error_code(), grpc::CANCELLED);
}

}  // namespace
}  // namespace stiefel
