// The command stiefel-server: signals, and the checks that operators and containers call.
#include <grpcpp/grpcpp.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <thread>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/flags.h"
#include "server/limits/freed_memory.h"
#include "server/server.h"
#include "server/transport/descriptor_limit.h"
#include "server/transport/listener.h"

namespace {

using stiefel::server::Options;

using stiefel::server::Flags;

/// What the process gets beyond the grace period to end by itself.
constexpr auto last_resort = std::chrono::milliseconds(1900);

int health_check(const std::string& address, const std::string& service) {
  if (const std::string fault = stiefel::server::sound_address(address); !fault.empty()) {
    std::cerr << "--address: " << fault << '\n';
    return 1;
  }
  const auto stub = grpc::health::v1::Health::NewStub(
      grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(2));
  grpc::health::v1::HealthCheckRequest request;
  request.set_service(service);
  grpc::health::v1::HealthCheckResponse response;
  const auto status = stub->Check(&context, request, &response);
  if (!status.ok()) {
    std::cerr << address << ": " << status.error_message() << '\n';
    return 1;
  }
  std::cerr << grpc::health::v1::HealthCheckResponse::ServingStatus_Name(response.status()) << '\n';
  return response.status() == grpc::health::v1::HealthCheckResponse::SERVING ? 0 : 1;
}

/// Sends this process SIGTERM when stdin ends, that is when the parent is gone.
void watch_parent() {
  std::thread([] {
    char ignored[256];
    while (true) {
      const ssize_t got = read(STDIN_FILENO, ignored, sizeof ignored);
      if (got == 0 || (got < 0 && errno != EINTR)) break;
    }
    kill(getpid(), SIGTERM);
  }).detach();
}

/// Ends the process with status 0 after that time, whatever still runs.
void exit_after(std::chrono::milliseconds time) {
  std::thread([time] {
    std::this_thread::sleep_for(time);
    std::cerr << "stiefel-server: work that does not stop was abandoned" << std::endl;
    _exit(0);
  }).detach();
}

/// Status 0 if a server could start with these flags; a server that runs is left alone.
int check(const Options& options) {
  int status = 0;
  for (const std::string& address : options.listen) {
    if (const auto fault = stiefel::server::listen_fault(address)) {
      std::cerr << "--listen: " << address << ": " << *fault << '\n';
      status = 1;
    }
  }
  stiefel::server::raise_descriptor_limit();
  const std::size_t most = stiefel::server::possible_connections(options.connections.most);
  if (most < options.connections.most) {
    std::cerr << "--max-connections: " << options.connections.most
              << ": the limit of file descriptors leaves " << most << '\n';
    status = 1;
  }
  if (status == 0) std::cout << "the flags are sound; connections at once: " << most << '\n';
  return status;
}

int serve(Options options, bool exit_with_parent) {
  // Every thread inherits the mask, so that only sigwait sees the signals.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  stiefel::server::raise_descriptor_limit();
  stiefel::server::keep_little_freed_memory();
  options.connections.unreachable = [] {
    std::cerr << "stiefel-server: does not answer its own connections" << std::endl;
    _exit(1);
  };
  try {
    stiefel::server::Server server(options);
    for (const std::string& address : server.addresses()) {
      std::cout << "listening on " << address << std::endl;
    }
    if (exit_with_parent) watch_parent();
    int received = 0;
    sigwait(&signals, &received);
    exit_after(options.grace + last_resort);
    server.shutdown();
    return 0;
  } catch (const std::exception& exception) {
    std::cerr << "stiefel-server: " << exception.what() << '\n';
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Serves simulations over gRPC. Prints 'listening on ADDRESS' when it does.");
  app.set_version_flag("--version", "stiefel-server " STIEFEL_VERSION);
  Flags flags;
  flags.add_to(app);

  std::string address = "127.0.0.1:50551";
  std::string service;
  auto* healthcheck = app.add_subcommand("healthcheck", "Exit status 0 if a server serves, else 1");
  healthcheck->add_option("--address", address, "Where it listens")->envname("STIEFEL_LISTEN");
  healthcheck->add_option("--service", service, "A service's full name; empty: the whole server");
  auto* checked = app.add_subcommand(
      "check", "Exit status 0 if a server could start with the flags beside it, else not 0");
  checked->fallthrough();
  auto* table = app.add_subcommand("flags", "Prints the flags as a table in Markdown");
  CLI11_PARSE(app, argc, argv);

  if (*healthcheck) return health_check(address.substr(0, address.find(',')), service);
  if (*table) {
    std::cout << stiefel::server::flag_table(app);
    return 0;
  }
  return *checked ? check(flags.options()) : serve(flags.options(), flags.exit_with_parent);
}
