// Allocations that fail on the threads that compute: each in turn, and the process lives. This
// program has an operator new of its own.
#include <dlfcn.h>
#include <google/protobuf/text_format.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>
#include <string_view>

#include "tests/calls/make_call.h"
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

using namespace std::chrono_literals;
using google::protobuf::Message;

/// What a caller gets of one call: the samples and numbers, as text or bytes, and the end.
struct Heard {
  std::string call;
  std::string said;
  grpc::Status status;
};

/// Far beyond the work of any of these calls: a call that never ends fails the test.
constexpr auto deadline = 60s;

/// Beside those of every RPC. A session "large" has samples of 68 KiB; "resumed" begins with the
/// checkpoint before it.
constexpr const char* more = R"(
  calls { create_session { session_id: "small" } }
  calls { create_session { session_id: "large" } }
  calls { step { session_id: "small" to: 60000 } }
  calls { step { session_id: "small" to: 700 return_checkpoint: true } }
  calls { create_session { session_id: "resumed" } }
  calls { step { session_id: "resumed" to: 710 } }
  calls { stream { session_id: "small" to: 3000 every: 2 checkpoint_every: 1500 } }
  calls { stream { session_id: "large" to: 12 checkpoint_every: 6 } }
  calls { step { session_id: "large" to: 9 return_checkpoint: true } }
  calls { drive { requests { session_id: "small" to: 3 } requests { to: 40000 } requests { to: 5 } } }
  calls { summarize { session_id: "small" to: 400 every: 10 times: [0, 0.995, 1.99, 2.985] checkpoint_every: 200 } }
  calls { convert { to: "symmetric_rigid_body" } }
  calls { delete_session { session_id: "small" } }
  calls { delete_session { session_id: "large" } }
  calls { delete_session { session_id: "resumed" } }
)";

Calls all_calls() {
  Calls all = every_call(), others;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(more, &others));
  for (Call& call : *others.mutable_calls()) {
    if (call.has_create_session())
      *call.mutable_create_session()->mutable_scene() =
          call.create_session().session_id() == "large"
              ? wire_scene({.method = "rk4", .dimension = 66})
              : wire_scene();
    if (call.has_convert()) *call.mutable_convert()->mutable_scene() = wire_scene();
  }
  all.MergeFrom(others);
  // What a run before could not delete would stand in the list of sessions.
  Calls with_deletions;
  for (const Call& call : all.calls())
    if (call.has_delete_session()) *with_deletions.add_calls() = call;
  with_deletions.MergeFrom(all);
  return with_deletions;
}

/// The bytes of every Field in a message.
std::string fields_in(const Message& message) {
  if (const auto* field = dynamic_cast<const v1::Field*>(&message)) return field->value().data();
  std::string bytes;
  const auto& reflection = *message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> set;
  reflection.ListFields(message, &set);
  for (const auto* one : set) {
    if (one->message_type() == nullptr) continue;
    if (!one->is_repeated()) bytes += fields_in(reflection.GetMessage(message, one));
    for (int i = 0; one->is_repeated() && i < reflection.FieldSize(message, one); ++i)
      bytes += fields_in(reflection.GetRepeatedMessage(message, one, i));
  }
  return bytes;
}

/// What in a reply is the same every time, however the samples are divided into messages.
std::string said(const Message& reply) {
  std::string text;
  if (const auto* step = dynamic_cast<const v1::StepResponse*>(&reply))
    return bytes_of(step->sample());
  if (const auto* drive = dynamic_cast<const v1::DriveResponse*>(&reply))
    return bytes_of(drive->step().sample());
  if (const auto* stream = dynamic_cast<const v1::StreamResponse*>(&reply)) {
    for (const auto step : stream->steps()) text += std::to_string(step) + ' ';
    return text + fields_in(reply);
  }
  if (const auto* diagnosis = dynamic_cast<const v1::DiagnoseResponse*>(&reply))
    for (const auto& one : diagnosis->invariants()) text += std::to_string(one.value()) + ' ';
  if (const auto* geodesic = dynamic_cast<const v1::ConnectResponse*>(&reply))
    return std::to_string(geodesic->energy());
  if (const auto* growth = dynamic_cast<const v1::LyapunovSpectrumResponse*>(&reply))
    for (const double exponent : growth->exponents()) text += std::to_string(exponent) + ' ';
  if (const auto* part = dynamic_cast<const v1::MeasureTradeoffResponse*>(&reply))
    return part->has_point() ? "point " : "other ";
  if (const auto* list = dynamic_cast<const v1::ListSessionsResponse*>(&reply))
    for (const auto& session : list->sessions()) text += session.session_id() + ' ';
  if (const auto* catalogue = dynamic_cast<const v1::DescribeResponse*>(&reply))
    return std::to_string(catalogue->systems_size());
  return text + fields_in(reply);
}

/// Makes the calls of every_call.txtpb, and longer ones of small and large sessions: the same calls
/// every time, which leave no session.
std::vector<Heard> call_all(const std::shared_ptr<grpc::Channel>& channel) {
  static const Calls all = all_calls();
  std::vector<Heard> heard;
  std::string checkpoint;
  for (Call call : all.calls()) {
    if (call.create_session().session_id() == "resumed")
      call.mutable_create_session()->set_checkpoint(checkpoint);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + deadline);
    Heard& one = heard.emplace_back(name_of(call), "", grpc::Status());
    one.status = make(channel, context, call, [&](const Message& reply) {
      one.said += said(reply);
      if (const auto* step = dynamic_cast<const v1::StepResponse*>(&reply))
        checkpoint = step->checkpoint();
      return true;
    });
  }
  return heard;
}

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
