// The command stiefel-server: signals, and the checks that operators and containers call.
#include <google/protobuf/stubs/logging.h>
#include <grpc/grpc.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <latch>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>

#include "server/connections/callers.h"
#include "server/program/flags.h"
#include "server/program/healthcheck.h"
#include "server/scheduling/memory_limit.h"
#include "server/scheduling/process.h"
#include "server/server.h"

namespace {

using namespace stiefel::server;
using namespace std::chrono_literals;

/// The time beyond the grace period that the process gets to end by itself.
constexpr auto last_resort = 1900ms;

/// Writes a line of less than PIPE_BUF bytes to stderr, unless that would block for longer than
/// 100 ms: on a pipe that nobody reads.
void write_stderr(std::string_view line) {
  pollfd descriptor{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&descriptor, 1, 100) > 0)
    static_cast<void>(write(STDERR_FILENO, line.data(), line.size()) > 0);
}

/// Ends the process with status 0 after a time, on a thread that nobody waits for.
void exit_after(std::chrono::milliseconds time, std::string_view line = {}) {
  try {
    std::thread([=] {
      std::this_thread::sleep_for(time);
      write_stderr(line);
      _exit(0);
    }).detach();
  } catch (const std::system_error&) {
    write_stderr("stiefel-server: the system gives no thread that bounds the time of the end\n");
  }
}

/// Handles SIGABRT during the start: gRPC aborts where the system gives no thread or no memory.
void tell_that_it_cannot_start(int) {
  write_stderr(
      "stiefel-server: cannot start: a library aborted; limits of threads and memory are a likely "
      "reason\n");
  _exit(1);
}

/// Sends this process SIGTERM when stdin ends, which means that the parent is gone.
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

/// Prints the token and the line for its file on stdout, for programs, and what they are on stderr.
void print_token(const std::string& name) {
  const NewToken made = make_token(name);
  std::cout << made.token << '\n' << made.line << std::endl;
  std::cerr << "The first line is the token. Give it to the caller; it cannot be shown again.\n"
               "Add the second line to the file of --tokens.\n";
}

void print_check(const Options& options, const std::vector<std::string>& warnings) {
  for (const std::string& text : warnings) std::cerr << "warning: " << text << '\n';
  check(options);
  const Quota limits = limits_of_principals(options);
  const auto text = [](std::uint64_t limit) {
    return limit > 0 ? std::to_string(limit) : "no limit";
  };
  std::cout << "the flags are sound; of one principal, sessions: " << text(*limits.sessions)
            << ", bytes of memory: " << text(*limits.memory) << '\n';
}

void serve(const Options& options, bool exit_with_parent,
           const std::vector<std::string>& warnings) {
  // gRPC's event engine polls a set of descriptors in which no connection is, and aborts the
  // process if that fails, as it did once in 1700 starts.
  setenv("GRPC_EXPERIMENTS", "-posix_event_engine_enable_polling", 0);
  // The lines of gRPC and protobuf would wait for the reader of stderr with the threads that serve.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  google::protobuf::SetLogHandler(nullptr);
  signal(SIGABRT, &tell_that_it_cannot_start);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // a store at the process's limit of file sizes counts as full
  // Every thread inherits the mask, so that only sigwait sees the signals. A server that is still
  // starting, which may take long with a large store, has promised nothing and ends at once.
  static sigset_t signals;
  static std::atomic<bool> started = false;
  static std::latch ended(1);
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([grace = options.grace] {
    int received = 0;
    sigwait(&signals, &received);
    if (!started.exchange(true)) {
      write_stderr("stiefel-server: ends before it has started\n");
      _exit(0);
    }
    exit_after(grace + last_resort,
               "stiefel-server: ends 2 s after the grace period without waiting any longer\n");
    ended.count_down();
  }).detach();

  raise_descriptor_limit();
  keep_little_freed_memory();
  const Log log(options.log_level, options.log_json);
  for (const std::string& text : warnings) log.line(Log::Level::warn, text);
  // gRPC's last shutdown waits up to 10 s for a thread that polls. The library is never shut down
  // here, so that the end of the server does not wait for it.
  grpc_init();
  std::optional<Server> server(options);
  if (started.exchange(true)) pause();  // the process is ending
  signal(SIGABRT, SIG_DFL);
  if (exit_with_parent) watch_parent();
  for (const std::string& address : server->addresses())
    std::cout << "listening on " << address << std::endl;
  if (const std::string url = server->metrics_url(); !url.empty())
    std::cout << "metrics at " << url << std::endl;
  ended.wait();
  server->shutdown();
  server.reset();
  exit_after(500ms);  // gRPC waits at exit for up to 10 s until the last of its objects is gone
}

}  // namespace

int main(int argc, char** argv) {
  // A process that was started through a loader, as from the wheel, has the loader's name.
  pthread_setname_np(pthread_self(), "stiefel-server");
  CLI::App app(
      "Serves simulations over gRPC. Prints 'listening on ADDRESS' for each address when it is "
      "ready.",
      "stiefel-server");
  app.set_version_flag("--version", "stiefel-server " STIEFEL_VERSION);
  Flags flags(app);

  HealthCheck question;
  auto* healthcheck = app.add_subcommand(
      "healthcheck", "Asks a running server for its health: exit status 0 if it serves, else 1");
  healthcheck->add_option("--address", question.address,
                          "Address of the server; by default the first one of --listen");
  healthcheck->add_option("--service", question.service,
                          "Full name of a service; empty: the whole server");
  healthcheck
      ->add_option("--tls-ca", question.ca,
                   "PEM file of the authorities that signed the server's certificate. Default with "
                   "--tls-cert: any certificate is accepted")
      ->envname("STIEFEL_TLS_CA")
      ->type_name("FILE");
  healthcheck->fallthrough();
  std::string name;
  auto* token =
      app.add_subcommand("token", "Prints a new token, and the line for the file of --tokens");
  token->add_option("NAME", name, "Name of the principal that owns the token and its sessions")
      ->required();
  auto* checked = app.add_subcommand(
      "check", "Checks the given flags: exit status 0 if a server could start with them");
  checked->fallthrough();
  auto* table = app.add_subcommand("flags", "Prints all flags as a Markdown table");
  try {
    app.parse(argc, argv);
    check_variables(app);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "stiefel-server: error: " << error.what() << "\nSee stiefel-server --help\n";
    return 2;
  }
  const Options& options = flags.options;
  if (*healthcheck) {
    if (question.address.empty()) question.address = options.listen.front();
    question.tls = options.access.tls;
    return health_check(question);
  }
  try {
    enlarge_thread_stacks();
    if (*token)
      print_token(name);
    else if (*table)
      std::cout << flag_table(app);
    else if (*checked)
      print_check(options, unknown_variables(app));
    else
      serve(options, flags.exit_with_parent, unknown_variables(app));
    return 0;
  } catch (const std::bad_alloc&) {
    std::cerr << "stiefel-server: cannot start: the system gives too little memory\n";
  } catch (const std::system_error& error) {
    std::cerr << "stiefel-server: cannot start: the system gives no thread: " << error.what()
              << "; see ulimit -u, ulimit -v and the control group's limits\n";
  } catch (const std::exception& exception) {
    std::cerr << "stiefel-server: " << exception.what() << '\n';
  }
  return 1;
}
