// Occupies all threads of the server with Steps over 10¹² steps. Measures how much slower another
// session's Step is meanwhile, and how long the server still computes after the long Steps are
// cancelled. Arguments: address of the server, its pid, its number of threads, repeats.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <future>
#include <list>
#include <stdexcept>
#include <thread>

#include "stiefel/client/client.h"
#include "tests/bench/measure.h"
#include "tests/bench/process.h"
#include "tests/bench/wire_scenes.h"

namespace {

using namespace stiefel;
using namespace std::chrono_literals;

/// A running Step that would take days.
class LongStep {
 public:
  LongStep(v1::SimulationService::Stub& stub, const std::string& session_id) {
    request_.set_session_id(session_id);
    request_.set_to(1'000'000'000'000);
    stub.async()->Step(&context_, &request_, &response_,
                       [this](const grpc::Status& status) { done_.set_value(status); });
  }
  void cancel() { context_.TryCancel(); }
  void wait() {
    if (done_.get_future().get().error_code() != grpc::StatusCode::CANCELLED) {
      throw std::runtime_error("the long Step was not cancelled");
    }
  }

 private:
  grpc::ClientContext context_;
  v1::StepRequest request_;
  v1::StepResponse response_;
  std::promise<grpc::Status> done_;
};

/// Makes `calls` Steps over `stride` steps each and returns the milliseconds that each takes.
std::vector<double> step_times(const client::Session& session, std::int64_t& to,
                               std::int64_t stride, int calls) {
  std::vector<double> times;
  for (int i = 0; i < calls; ++i) {
    to += stride;
    times.push_back(1e3 * bench::seconds([&] { session.step(to); }));
  }
  return times;
}

/// Returns the processor time in milliseconds that the process takes from now on, per thread: the
/// time until its threads were free, if all were busy until then.
double milliseconds_until_free(int pid, int threads) {
  const double start = bench::cpu_seconds(pid);
  std::this_thread::sleep_for(1s);
  return 1e3 * (bench::cpu_seconds(pid) - start) / threads;
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

void measure(const client::Client& client, v1::SimulationService::Stub& stub, int pid, int threads,
             int repeats, int N) {
  const std::string suffix = ", N = " + std::to_string(N);
  bench::Figure free{"Cancelled Step until its worker is free" + suffix, "ms", 50};
  bench::Figure brief{"Delay of another's next step, worst" + suffix, "ms", 20};
  bench::Figure pooled{"Delay of another's 1000 steps, worst" + suffix, "ms", 20};
  const client::Session other = client.temporary(bench::wire_scene(3, 2));
  std::int64_t to = 0;
  for (int i = 0; i < repeats; ++i) {
    const double brief_alone = bench::median(step_times(other, to, 1, 100));
    const double pooled_alone = bench::median(step_times(other, to, 1000, 100));

    std::list<client::Session> sessions;
    std::list<LongStep> steps;
    const double cpu = bench::cpu_seconds(pid);
    for (int t = 0; t < threads; ++t) {
      sessions.push_back(client.temporary(bench::wire_scene(N, static_cast<unsigned>(10 + t))));
      steps.emplace_back(stub, sessions.back().id());
    }
    while (bench::cpu_seconds(pid) < cpu + 0.1) std::this_thread::sleep_for(10ms);
    brief.values.push_back(largest(step_times(other, to, 1, 100)) - brief_alone);
    pooled.values.push_back(largest(step_times(other, to, 1000, 100)) - pooled_alone);

    for (LongStep& step : steps) step.cancel();
    free.values.push_back(milliseconds_until_free(pid, threads));
    for (LongStep& step : steps) step.wait();
  }
  report(free);
  report(brief);
  report(pooled);
}

}  // namespace

int main(int, char** argv) {
  const int pid = std::stoi(argv[2]), threads = std::stoi(argv[3]), repeats = std::stoi(argv[4]);
  const auto client = client::Client::connect(argv[1]);
  const auto stub = v1::SimulationService::NewStub(
      grpc::CreateChannel(argv[1], grpc::InsecureChannelCredentials()));
  for (const int N : {3, 64}) measure(client, *stub, pid, threads, repeats, N);
}
