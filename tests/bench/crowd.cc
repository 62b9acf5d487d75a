// Measures the server's memory and threads while many calls stay open. Arguments: address of the
// server, its pid, "unread" or "idle", number of calls, N, number of sessions.
#include <grpcpp/grpcpp.h>

#include <algorithm>
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

std::shared_ptr<grpc::Channel> own_connection(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// Waits until all buffers are full and the server computes nothing any more.
void wait_until_idle(int pid) {
  const auto limit = std::chrono::steady_clock::now() + 60s;
  double cpu = bench::cpu_seconds(pid);
  for (int quiet = 0; quiet < 10;) {
    if (std::chrono::steady_clock::now() > limit) throw std::runtime_error("still busy");
    std::this_thread::sleep_for(100ms);
    const double now = bench::cpu_seconds(pid);
    quiet = now - cpu < 1e-3 ? quiet + 1 : 0;
    cpu = now;
  }
}

/// A Stream of 2⁴⁰ samples, on its own connection, from which nobody reads.
struct Unread {
  Unread(const std::string& address, const std::string& session_id)
      : stub(v1::SimulationService::NewStub(own_connection(address))) {
    v1::StreamRequest request;
    request.set_session_id(session_id);
    request.set_to(std::int64_t{1} << 40);
    reader = stub->Stream(&context, request);
  }
  ~Unread() {
    context.TryCancel();
    reader->Finish();
  }
  grpc::ClientContext context;
  std::unique_ptr<v1::SimulationService::Stub> stub;
  std::unique_ptr<grpc::ClientReader<v1::StreamResponse>> reader;
};

/// Measures streams that nobody reads. Each session may hold 64 MiB of checkpoints, so that at
/// large N all streams should share one session.
void unread(const std::string& address, int pid, int count, int N, int session_count) {
  const auto client = client::Client::connect(address);
  std::list<client::Session> sessions;
  std::list<Unread> streams;
  for (int i = 0; i < count; ++i) {
    if (i < session_count) sessions.push_back(client.temporary(bench::wire_scene(N)));
    streams.emplace_back(address, sessions.back().id());
  }
  wait_until_idle(pid);
  report(bench::Figure{"Memory of the server, " + std::to_string(count) +
                           " streams nobody reads, N = " + std::to_string(N) + ", " +
                           std::to_string(session_count) + " sessions",
                       "MB",
                       100,
                       {1.024e-3 * bench::process_status(pid, "VmHWM")}});
}

void idle(const std::string& address, int pid, int count) {
  constexpr int calls_a_connection = 100;
  std::list<client::Client> clients;
  std::list<client::Session> sessions;
  std::list<client::Drive> drives;
  double threads = 0;
  for (int i = 0; i < count; ++i) {
    if (i % calls_a_connection == 0) {
      clients.emplace_back(own_connection(address));
      sessions.push_back(clients.back().temporary(bench::wire_scene(3)));
    }
    drives.push_back(sessions.back().drive());
    drives.back().step(i % calls_a_connection);
    threads = std::max(threads, bench::process_status(pid, "Threads"));
  }
  wait_until_idle(pid);
  threads = std::max(threads, bench::process_status(pid, "Threads"));
  report(bench::Figure{
      "Threads of the server, " + std::to_string(count) + " idle streams", "", 32, {threads}});
}

}  // namespace

int main(int, char** argv) {
  const int pid = std::stoi(argv[2]), count = std::stoi(argv[4]);
  if (std::string(argv[3]) == "idle") {
    idle(argv[1], pid, count);
  } else {
    unread(argv[1], pid, count, std::stoi(argv[5]), std::stoi(argv[6]));
  }
}
