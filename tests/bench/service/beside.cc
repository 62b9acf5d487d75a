// Measures a server's small calls, alone and beside 64 endless Steps of another principal. Prints a
// line "name quantile value" for each. Arguments: address, what (step, drive, million, short, idle
// or beside), the tokens of the two principals, the file of the server's certificate.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "stiefel/v1/simulation.grpc.pb.h"
#include "tests/bench/measure.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;
using namespace std::chrono_literals;
using Stub = v1::SimulationService::Stub;

constexpr int endless_calls = 64;
/// About the steps of `variational` for N = 3 in a millisecond.
constexpr double steps_a_millisecond = 3000;

struct Caller {
  std::string token;
  std::unique_ptr<Stub> stub;

  std::unique_ptr<grpc::ClientContext> context() const {
    auto context = std::make_unique<grpc::ClientContext>();
    context->AddMetadata("authorization", "Bearer " + token);
    return context;
  }
  void create(const std::string& id, const char* method) const {
    v1::CreateSessionRequest request;
    request.set_session_id(id);
    *request.mutable_scene() = bench::wire_scene(3, 7);
    request.mutable_scene()->mutable_method()->set_name(method);
    v1::CreateSessionResponse response;
    check(stub->CreateSession(context().get(), request, &response));
  }
  void step(const std::string& id, std::int64_t to) const {
    v1::StepRequest request;
    request.set_session_id(id);
    request.set_to(to);
    v1::StepResponse response;
    check(stub->Step(context().get(), request, &response));
  }
  void stream(const std::string& id, std::int64_t to) const {
    v1::StreamRequest request;
    request.set_session_id(id);
    request.set_to(to);
    request.add_fields("Q");
    const auto of_call = context();
    const auto reader = stub->Stream(of_call.get(), request);
    v1::StreamResponse message;
    std::int64_t samples = 0;
    while (reader->Read(&message)) samples += message.steps_size();
    check(reader->Finish());
    if (samples != to + 1) throw std::runtime_error("samples are missing");
  }
  static void check(const grpc::Status& status) {
    if (!status.ok()) throw std::runtime_error(status.error_message());
  }
};

Caller caller(const std::string& address, std::string token, const std::string& certificate) {
  std::ostringstream text;
  text << std::ifstream(certificate).rdbuf();
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = text.str();
  grpc::ChannelArguments arguments;
  arguments.SetSslTargetNameOverride("localhost");
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return {std::move(token), v1::SimulationService::NewStub(grpc::CreateCustomChannel(
                                address, grpc::SslCredentials(options), arguments))};
}

/// Makes `count` calls with a pause between them, and prints quantiles of their milliseconds.
template <class Call>
void measure(const std::string& name, int count, std::chrono::milliseconds pause,
             const Call& call) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    times.push_back(1e3 * bench::seconds([&] { call(i); }));
    std::this_thread::sleep_for(pause);
  }
  std::ranges::sort(times);
  for (const int percent : {50, 95, 99})
    std::printf("%s p%d %.4f\n", name.c_str(), percent,
                times[times.size() * static_cast<std::size_t>(percent) / 100]);
}

void drive(const Caller& caller) {
  const auto context = caller.context();
  const auto drive = caller.stub->Drive(context.get());
  measure("drive", 4000, 0ms, [&](int i) {
    v1::DriveRequest request;
    request.set_session_id("exact");
    request.set_to(i + 1);
    v1::DriveResponse response;
    if (!drive->Write(request) || !drive->Read(&response) || response.has_error())
      throw std::runtime_error("the Drive failed");
  });
}

void steps(const Caller& caller, const std::string& where) {
  measure(where + "_tiny", 1500, 2ms, [&](int i) { caller.step("exact", i); });
  double to = 0;
  for (const double milliseconds : {0.3, 1.0, 5.0}) {
    std::ostringstream name;
    name << where << '_' << milliseconds << "_ms";
    measure(name.str(), milliseconds < 5 ? 300 : 150, 2ms, [&](int) {
      to += milliseconds * steps_a_millisecond;
      caller.step("steps", static_cast<std::int64_t>(to));
    });
  }
}

}  // namespace

int main(int, char** argv) {
  const std::string what = argv[2];
  const Caller other = caller(argv[1], argv[3], argv[5]), mine = caller(argv[1], argv[4], argv[5]);
  mine.create("exact", "exact");
  mine.create("steps", "variational");
  if (what == "step") measure(what, 3000, 0ms, [&](int i) { mine.step("exact", i); });
  if (what == "drive") drive(mine);
  if (what == "million") measure(what, 4, 0ms, [&](int) { mine.stream("steps", 1'000'000); });
  if (what == "short") measure(what, 400, 0ms, [&](int) { mine.stream("steps", 100); });
  if (what == "idle") steps(mine, what);
  if (what != "beside") return 0;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::jthread> threads;
  for (int i = 0; i < endless_calls; ++i) {
    other.create("endless" + std::to_string(i), "variational");
    contexts.push_back(other.context());
    threads.emplace_back([&, i, context = contexts.back().get()] {
      v1::StepRequest request;
      request.set_session_id("endless" + std::to_string(i));
      request.set_to(std::int64_t{1} << 50);
      v1::StepResponse response;
      other.stub->Step(context, request, &response);
    });
  }
  std::this_thread::sleep_for(3s);
  steps(mine, what);
  for (const auto& context : contexts) context->TryCancel();
}
