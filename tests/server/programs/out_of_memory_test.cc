// Allocations that fail on the threads that compute: each in turn, and the process lives. This
// program has an operator new of its own.
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string_view>

#include "tests/server/harness.h"

namespace {

/// Smaller ones may be gRPC's own, which it does not survive.
constexpr std::size_t least = 2048;
/// The larger ones of its library, the slices that it serializes into, it does not survive either.
bool of_grpc(const void* caller) {
  Dl_info where;
  return dladdr(caller, &where) != 0 &&
         std::string_view(where.dli_fname).find("libgrpc") != std::string_view::npos;
}
/// Which of the allocations from now on fails; 0: none.
std::atomic<int> failing = 0;

bool on_pool() {
  thread_local const bool is = [] {
    char name[16] = {};
    pthread_getname_np(pthread_self(), name, sizeof name);
    return std::string_view(name) == "grpcpp_sync_ser";
  }();
  return is;
}

}  // namespace

// malloc and free are the pair here; g++ sees them inlined one by one.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (size >= least && failing > 0 && on_pool() && !of_grpc(__builtin_return_address(0)) &&
      --failing == 0)
    throw std::bad_alloc();
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace stiefel {
namespace {

using namespace std::chrono_literals;

grpc::Status read_slowly(test::Stub& stub) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + 30s);
  v1::StreamRequest request;
  request.set_session_id("s");
  request.set_to(12);
  request.set_every(1);
  const auto stream = stub.Stream(&context, request);
  v1::StreamResponse message;
  // The server rests meanwhile, which takes memory too.
  while (stream->Read(&message)) std::this_thread::sleep_for(2ms);
  return stream->Finish();
}

/// Until none fails any more: then all that a stream allocates has failed once.
TEST(OutOfMemory, EveryAllocationOfAStreamMayFail) {
  test::Harness harness({.threads = 1});
  int refused = 0, k = 1;
  for (;; ++k) {
    ASSERT_LT(k, 2000) << "allocations without end";
    const std::string id = "s";
    harness.create(id, test::wire_scene({.method = "rk4", .dimension = 100}));
    failing = k;
    const grpc::Status status = read_slowly(*harness.stub);
    const bool all_succeeded = failing.exchange(0) > 0;
    if (!status.ok()) {
      EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
      ++refused;
    }
    grpc::ClientContext context;
    v1::DeleteSessionRequest request;
    request.set_session_id(id);
    v1::DeleteSessionResponse response;
    ASSERT_TRUE(harness.stub->DeleteSession(&context, request, &response).ok());
    if (all_succeeded) break;
  }
  EXPECT_GT(refused, 3);
  RecordProperty("allocations", k);
}

TEST(OutOfMemory, EveryAllocationOfAStepMayFail) {
  test::Harness harness({.threads = 1});
  const test::Case which{.method = "rk4", .dimension = 100};
  harness.create("s", test::wire_scene(which));
  const Scene scene = test::scene(which);
  int refused = 0;
  for (int k = 1; k <= 20; ++k) {
    grpc::ClientContext context;
    v1::StepRequest request;
    request.set_session_id("s");
    request.set_to(10 * k);
    v1::StepResponse response;
    failing = k;
    const grpc::Status status = harness.stub->Step(&context, request, &response);
    failing = 0;
    if (status.ok()) continue;
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
    ++refused;
    // The step that failed leaves no state behind that is none.
    EXPECT_TRUE(test::bytes_of(harness.step("s", 10 * k).sample()) ==
                test::expected_bytes(scene, 10 * k));
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace stiefel
