// Loads a server with ten times as many long calls as it has threads, made by four principals of
// which one is greedy. Measures how much slower another caller's short calls are than at an idle
// server, and how the principals share the server. Arguments: "serve" and the number of threads,
// for a server that takes each caller's name from the metadata `x-principal`; or the address of
// that server, its number of threads, repeats, short calls per repeat.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <list>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "server/server.h"
#include "stiefel/client/error.h"
#include "stiefel/v1/simulation.grpc.pb.h"
#include "tests/bench/measure.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;
using namespace std::chrono_literals;
using Stub = v1::SimulationService::Stub;

constexpr int principals = 4;
/// Steps of a long call: about 20 ms on one thread.
constexpr std::int64_t long_steps = 100'000;
/// Steps of the other caller's calls: gRPC's thread answers 1 step, a worker 1000 steps (0.2 ms) as
/// a short call, and 12 000 (2 ms) as one just above the limit of short calls.
constexpr std::array<std::int64_t, 3> short_steps = {1, 1000, 12'000};
constexpr std::array<const char*, 3> kinds = {"an inline", "a short pooled", "a medium"};
/// The least number of long calls from which the shares are computed.
constexpr std::int64_t least_calls = 400;
/// The server's limit of concurrent calls of a principal; the greedy one makes more.
constexpr int concurrent_calls_limit = 12;

int serve(int threads) {
  server::Options options{.listen = {"127.0.0.1:0"}, .threads = threads};
  options.quota.calls = concurrent_calls_limit;
  options.identify = [](const grpc::ServerContextBase& context) {
    const auto sent = context.client_metadata().find("x-principal");
    if (sent == context.client_metadata().end()) return server::Principal{};
    return server::Principal{std::string(sent->second.data(), sent->second.size())};
  };
  const server::Server server(options);
  std::cout << "listening on " << server.addresses()[0] << std::endl;
  while (std::cin.get() != EOF) {
  }
  return 0;
}

std::unique_ptr<Stub> connect(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return v1::SimulationService::NewStub(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
}

void create(Stub& stub, const std::string& principal, const std::string& id, unsigned seed) {
  v1::CreateSessionRequest request;
  request.set_session_id(id);
  *request.mutable_scene() = bench::wire_scene(3, seed);
  v1::CreateSessionResponse response;
  grpc::ClientContext context;
  context.AddMetadata("x-principal", principal);
  const auto status = stub.CreateSession(&context, request, &response);
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

grpc::Status step(Stub& stub, const std::string& principal, const std::string& id,
                  std::int64_t to) {
  v1::StepRequest request;
  request.set_session_id(id);
  request.set_to(to);
  v1::StepResponse response;
  grpc::ClientContext context;
  context.AddMetadata("x-principal", principal);
  return stub.Step(&context, request, &response);
}

struct Counts {
  std::array<std::atomic<std::int64_t>, principals> done{};  // long calls
  std::atomic<int> refused = 0, without_delay = 0;

  std::int64_t all() const { return std::accumulate(done.begin(), done.end(), std::int64_t{0}); }
};

/// Makes long calls, one after the other, until `stop` is requested.
void keep_busy(const std::stop_token& stop, const std::string& address, int principal,
               const std::string& id, Counts& counts) {
  const auto stub = connect(address);
  create(*stub, std::to_string(principal), id, 7);
  for (std::int64_t to = long_steps; !stop.stop_requested();) {
    const auto status = step(*stub, std::to_string(principal), id, to);
    if (status.ok()) {
      ++counts.done[static_cast<std::size_t>(principal)];
      to += long_steps;
      continue;
    }
    if (status.error_code() != grpc::RESOURCE_EXHAUSTED)
      throw std::runtime_error(status.error_message());
    ++counts.refused;
    const auto delay = client::Error(status).retry_delay();
    if (!delay) ++counts.without_delay;
    std::this_thread::sleep_for(delay.value_or(100ms));
  }
}

double quantile(std::vector<double> values, double which) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(which * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Makes `calls` short calls and returns the milliseconds that each takes.
std::vector<double> short_calls(Stub& stub, const std::string& id, std::int64_t& to,
                                std::int64_t stride, int calls) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    to += stride;
    grpc::Status status;
    times.push_back(1e3 * bench::seconds([&] { status = step(stub, "3", id, to); }));
    if (!status.ok()) throw std::runtime_error(status.error_message());
    std::this_thread::sleep_for(2ms);  // the caller does something else between its calls
  }
  return times;
}

struct Latencies {
  bench::Figure p95, p99;
};

void measure(const std::string& address, int threads, int repeats, int calls) {
  std::array<Latencies, short_steps.size()> latencies;
  for (std::size_t k = 0; k < short_steps.size(); ++k) {
    const std::string what = std::string("Overload, ") + kinds[k] + " Step's ";
    latencies[k].p95 = {.name = what + "p95 over idle", .unit = "x", .bound = 3};
    latencies[k].p99 = {.name = what + "p99 less idle", .unit = "ms", .bound = 10};
  }
  bench::Figure shares{
      .name = "Overload, largest departure of a principal's share", .unit = "", .bound = 0.2};
  bench::Figure untold{.name = "Overload, refusals without a time", .unit = "", .bound = 0};
  bench::Figure refused{.name = "Overload, refusals", .unit = ""};

  const auto stub = connect(address);
  create(*stub, "3", "short", 1);
  std::int64_t to = 0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::array<std::vector<double>, short_steps.size()> idle, busy;
    for (std::size_t k = 0; k < short_steps.size(); ++k)
      idle[k] = short_calls(*stub, "short", to, short_steps[k], calls);

    Counts counts;
    std::list<std::jthread> callers;
    for (int i = 0; i < 10 * threads; ++i) {
      // Each principal has two callers; the greedy one, number 0, has all others as well.
      const int principal = i < 2 * principals ? i % principals : 0;
      callers.emplace_back([&, principal, i, repeat](const std::stop_token& stop) {
        keep_busy(stop, address, principal,
                  "long-" + std::to_string(repeat) + "-" + std::to_string(i), counts);
      });
    }
    std::this_thread::sleep_for(1s);
    for (auto& done : counts.done) done = 0;
    for (std::size_t k = 0; k < short_steps.size(); ++k)
      busy[k] = short_calls(*stub, "short", to, short_steps[k], calls);
    while (counts.all() < least_calls) std::this_thread::sleep_for(10ms);
    std::array<double, principals> done{};
    std::ranges::copy(counts.done, done.begin());
    for (auto& caller : callers) caller.request_stop();
    callers.clear();

    for (std::size_t k = 0; k < short_steps.size(); ++k) {
      latencies[k].p95.values.push_back(quantile(busy[k], 0.95) / quantile(idle[k], 0.95));
      latencies[k].p99.values.push_back(quantile(busy[k], 0.99) - quantile(idle[k], 0.99));
    }
    const double all = std::accumulate(done.begin(), done.end(), 0.0);
    double departure = 0;
    for (const double calls_done : done)
      departure = std::max(departure, std::abs(calls_done * principals / all - 1));
    shares.values.push_back(departure);
    untold.values.push_back(counts.without_delay);
    refused.values.push_back(counts.refused);
  }
  for (const auto& [p95, p99] : latencies) {
    report(p95);
    report(p99);
  }
  for (const auto& figure : {shares, refused, untold}) report(figure);
}

}  // namespace

int main(int, char** argv) {
  if (std::string(argv[1]) == "serve") return serve(std::stoi(argv[2]));
  measure(argv[1], std::stoi(argv[2]), std::stoi(argv[3]), std::stoi(argv[4]));
}
