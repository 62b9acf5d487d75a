// Allocations that fail on the threads that compute: each in turn, and the process lives. This
// program has an operator new of its own.
#include <dlfcn.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <string_view>

#include "tests/server/programs/every_call.h"

namespace {

/// Smaller ones may be gRPC's own, which it does not survive.
constexpr std::size_t least = 2048;
/// The larger ones of its library, the slices that it serializes into, it does not survive either.
bool of_grpc(const void* caller) {
  Dl_info where;
  return dladdr(caller, &where) != 0 &&
         std::string_view(where.dli_fname).find("libgrpc") != std::string_view::npos;
}
/// Allocations of these threads so far, and the one that fails; 0: none.
std::atomic<int> allocations = 0, failing = 0;

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
  if (size >= least && on_pool() && !of_grpc(__builtin_return_address(0)) &&
      ++allocations == failing)
    throw std::bad_alloc();
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace stiefel::test {
namespace {

/// A status that names its reason or the field at fault.
bool is_typed(const grpc::Status& status) {
  v1::Status details;
  return status.error_code() != grpc::UNKNOWN && status.error_code() != grpc::UNIMPLEMENTED &&
         status.error_code() != grpc::DEADLINE_EXCEEDED &&
         details.ParseFromString(status.error_details()) &&
         (details.details_size() > 0 || details.code() == status.error_code());
}

/// A list misses sessions whose creation failed, and a fork or a checkpoint needs one.
void expect_right(const std::vector<Heard>& heard, const std::vector<Heard>& right) {
  ASSERT_EQ(heard.size(), right.size());
  bool failed = false;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    const Heard& call = heard[i];
    if (!call.status.ok()) {
      failed = true;
      EXPECT_TRUE(is_typed(call.status))
          << call.call << ": " << call.status.error_code() << " " << call.status.error_message();
      EXPECT_TRUE(right[i].said.starts_with(call.said)) << call.call << ": wrong before its error";
    } else if (!(failed && call.call == "list_sessions")) {
      EXPECT_TRUE(call.said == right[i].said) << call.call << ": wrong answer";
    }
  }
}

/// Each call ends with a typed error or the right answer, what a stream said before its error is
/// the beginning of the right answer, and all calls after it are as if nothing had failed.
TEST(OutOfMemory, AnAllocationOfEveryCallMayFail) {
  server::Options options;
  options.threads = 1;
  options.log_level = "off";
  Harness harness(options);
  const auto channel = harness.server.in_process_channel();
  const std::vector<Heard> right = call_all(channel);
  for (const Heard& call : right)
    ASSERT_TRUE(call.status.ok()) << call.call << ": " << call.status.error_message();
  allocations = 0;
  expect_right(call_all(channel), right);
  const int all = allocations;
  constexpr int runs = 30;
  int refused = 0;
  for (int run = 0; run < runs && !HasFailure(); ++run) {
    const int one = 1 + static_cast<int>(static_cast<std::int64_t>(all) * run / runs);
    SCOPED_TRACE("allocation " + std::to_string(one) + " of " + std::to_string(all));
    allocations = 0;
    failing = one;
    const std::vector<Heard> heard = call_all(channel);
    failing = 0;
    refused += std::ranges::any_of(heard, [](const Heard& call) { return !call.status.ok(); });
    expect_right(heard, right);
  }
  const std::vector<Heard> again = call_all(channel);
  for (const Heard& call : again)
    EXPECT_TRUE(call.status.ok()) << call.call << ": " << call.status.error_message();
  expect_right(again, right);
  EXPECT_GE(refused, runs / 2);
  RecordProperty("allocations", all);
  RecordProperty("refused", refused);
}

TEST(OutOfMemory, EveryAllocationOfAStepMayFail) {
  Harness harness({.threads = 1});
  const Case which{.method = "rk4", .dimension = 100};
  harness.create("s", wire_scene(which));
  const Scene scene = test::scene(which);
  int refused = 0;
  for (int k = 1; k <= 20; ++k) {
    grpc::ClientContext context;
    v1::StepRequest request;
    request.set_session_id("s");
    request.set_to(10 * k);
    v1::StepResponse response;
    allocations = 0;
    failing = k;
    const grpc::Status status = harness.stub->Step(&context, request, &response);
    failing = 0;
    if (status.ok()) continue;
    EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED) << status.error_message();
    ++refused;
    // The step that failed leaves no state behind that is none.
    EXPECT_TRUE(bytes_of(harness.step("s", 10 * k).sample()) == expected_bytes(scene, 10 * k));
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace stiefel::test
