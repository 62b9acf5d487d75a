// The command stiefel-server: signals, and the checks that operators and containers call.
#include <grpc/grpc.h>
#include <grpcpp/grpcpp.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <string_view>
#include <thread>

#include "server/connections/callers.h"
#include "server/connections/listener.h"
#include "server/observability/log.h"
#include "server/program/check.h"
#include "server/program/command_line.h"
#include "server/program/end_signal.h"
#include "server/program/flags.h"
#include "server/scheduling/memory_limit.h"
#include "server/scheduling/process.h"
#include "server/server.h"

namespace {

using namespace stiefel::server;

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
int print_token(const std::string& name) {
  try {
    const auto made = make_token(name);
    std::cout << made.token << '\n' << made.line << std::endl;
  } catch (const std::exception& exception) {
    std::cerr << "NAME: " << exception.what() << '\n';
    return 1;
  }
  std::cerr << "The first line is the token. Give it to the caller; it cannot be shown again.\n"
               "Add the second line to the file of --tokens.\n";
  return 0;
}

/// Handles SIGABRT during the start: gRPC aborts where the system gives no thread or no memory.
void tell_that_it_cannot_start(int) {
  constexpr std::string_view reason =
      "stiefel-server: cannot start: a library aborted; limits of threads and memory are a likely "
      "reason\n";
  static_cast<void>(write(STDERR_FILENO, reason.data(), reason.size()) > 0);
  _exit(1);
}

/// Throws std::runtime_error if the system does not give the threads of a server. `std::thread` and
/// gRPC would end the process later and without a reason.
void check_threads(const Options& options) {
  enlarge_thread_stacks();
  if (const auto fault = thread_fault(threads_of(options)))
    throw std::runtime_error("cannot start: " + *fault);
}

int serve(Options options, bool exit_with_parent) try {
  // gRPC's event engine polls a set of descriptors in which no connection is, and aborts the
  // process if that fails, as it did once in 1700 starts.
  setenv("GRPC_EXPERIMENTS", "-posix_event_engine_enable_polling", 0);
  // gRPC's own lines would wait for the reader of stderr with the threads that serve connections.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  signal(SIGABRT, &tell_that_it_cannot_start);
  check_threads(options);
  // Lives as long as the process, since its threads do.
  static EndSignal signal_to_end(options.grace);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // a store at the process's limit of file sizes counts as full
  raise_descriptor_limit();
  keep_little_freed_memory();
  const Log log(options.log_level, options.log_json);
  for (const std::string& text : unknown_variables()) log.line(Log::Level::warn, text);
  // gRPC's last shutdown waits up to 10 s for a thread that polls. The library is never shut down
  // here, so that the end of the server does not wait for it.
  grpc_init();
  options.waits_for = [](const char* what) { signal_to_end.waits_for(what); };
  std::optional<Server> server(options);
  signal_to_end.started();
  signal(SIGABRT, SIG_DFL);
  for (const std::string& address : server->addresses())
    std::cout << "listening on " << address << std::endl;
  if (const std::string url = server->metrics_url(); !url.empty())
    std::cout << "metrics at " << url << std::endl;
  if (exit_with_parent) watch_parent();
  signal_to_end.wait();
  server->shutdown();
  signal_to_end.waits_for("the end of the server's threads");
  server.reset();
  EndSignal::exit_soon();
  return 0;
} catch (const std::bad_alloc&) {
  std::cerr << "stiefel-server: cannot start: the system gives too little memory\n";
  return 1;
} catch (const std::exception& exception) {
  std::cerr << "stiefel-server: " << exception.what() << '\n';
  return 1;
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
                   "--tls-cert: on this machine's own addresses any certificate is accepted")
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

  if (*healthcheck) {
    if (question.address.empty()) question.address = flags.options.listen.front();
    question.tls = flags.options.access.tls;
    return health_check(question);
  }
  if (*token) return print_token(name);
  if (*table) {
    std::cout << flag_table(app);
    return 0;
  }
  return *checked ? check(flags.options) : serve(flags.options, flags.exit_with_parent);
}
