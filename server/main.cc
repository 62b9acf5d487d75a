// The command stiefel-server: flags, signals, and the check that containers call.
#include <grpcpp/grpcpp.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <thread>

#include "grpc/health/v1/health.grpc.pb.h"
#include "server/address.h"
#include "server/server.h"

namespace {

using stiefel::server::Options;

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

/// What CLI11 puts after "--listen: ".
std::string sound_address(const std::string& address) {
  const auto fault = stiefel::server::address_fault(address);
  return fault ? address + ": " + *fault : "";
}

int health_check(const std::string& address, const std::string& service) {
  if (const std::string fault = sound_address(address); !fault.empty()) {
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

int serve(const Options& options, bool exit_with_parent) {
  // Every thread inherits the mask, so that only sigwait sees the signals.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);
  try {
    stiefel::server::Server server(options);
    for (const std::string& address : server.addresses()) {
      std::cout << "listening on " << address << std::endl;
    }
    if (exit_with_parent) watch_parent();
    int received = 0;
    sigwait(&signals, &received);
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

  Options options;
  options.listen = {"127.0.0.1:50551"};
  options.log_level = "info";
  double idle_timeout = 3600;
  double grace = 3;
  std::string log_format = "text";
  bool exit_with_parent = false;
  app.add_option("--listen", options.listen,
                 "host:port (0: any free port) or unix:PATH; repeatable")
      ->envname("STIEFEL_LISTEN")
      ->delimiter(',')
      ->check(sound_address)
      ->capture_default_str();
  app.add_option("--threads", options.threads, "Threads that compute; 0: one a core")
      ->envname("STIEFEL_THREADS")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--max-sessions", options.max_sessions, "Sessions held at once")
      ->envname("STIEFEL_MAX_SESSIONS")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--idle-timeout", idle_timeout, "Seconds after which an unused session is dropped")
      ->envname("STIEFEL_IDLE_TIMEOUT")
      ->check(CLI::Range(0.001, 1e9))
      ->capture_default_str();
  app.add_option("--grace", grace, "Seconds that running work gets when the server is told to stop")
      ->envname("STIEFEL_GRACE")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "What is logged on stderr")
      ->envname("STIEFEL_LOG_LEVEL")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"}))
      ->capture_default_str();
  app.add_option("--log-format", log_format, "text or json")
      ->envname("STIEFEL_LOG_FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_flag("--exit-with-parent", exit_with_parent, "Stop when stdin ends; for child processes");

  std::string address = "127.0.0.1:50551";
  std::string service;
  auto* healthcheck = app.add_subcommand("healthcheck", "Exit status 0 if a server serves, else 1");
  healthcheck->add_option("--address", address, "Where it listens")->envname("STIEFEL_LISTEN");
  healthcheck->add_option("--service", service, "A service's full name; empty: the whole server");
  CLI11_PARSE(app, argc, argv);

  if (*healthcheck) return health_check(address.substr(0, address.find(',')), service);
  options.idle_timeout = milliseconds(idle_timeout);
  options.grace = milliseconds(grace);
  options.log_json = log_format == "json";
  return serve(options, exit_with_parent);
}
