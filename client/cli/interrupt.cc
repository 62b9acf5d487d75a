#include "client/cli/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <thread>

#include "client/cli/sinks/destination.h"

namespace stiefel::cli {
namespace {

constexpr timespec patience{.tv_sec = 3, .tv_nsec = 0};

std::atomic<int> received = 0;

/// Never destroyed, because a signal may come while the process ends.
std::stop_source& source() {
  static auto& one = *new std::stop_source;
  return one;
}

/// Ends the process. The first thread that calls it does so; all others wait forever.
void end(int signal, const std::string& how_far) {
  static std::atomic<bool> ending = false;
  if (ending.exchange(true)) {
    while (true) pause();
  }
  remove_partial_files();
  std::string line = "stiefel: interrupted";
  if (!how_far.empty()) line.append(" ").append(how_far);
  line += '\n';
  [[maybe_unused]] const ssize_t told = ::write(STDERR_FILENO, line.data(), line.size());
  ::signal(signal, SIG_DFL);
  sigset_t only;
  sigemptyset(&only);
  sigaddset(&only, signal);
  pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
  ::kill(getpid(), signal);
  _exit(128 + signal);
}

void watch(const sigset_t& signals) {
  int signal = 0;
  while (sigwait(&signals, &signal) != 0) {
  }
  received = signal;
  source().request_stop();
  sigtimedwait(&signals, nullptr, &patience);
  end(signal, "");
}

}  // namespace

void catch_interrupts() {
  source();
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now = {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN)
      sigaddset(&signals, signal);
  }
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] { watch(signals); }).detach();
}

std::stop_token interruption() { return source().get_token(); }

bool interrupted() { return received != 0; }

void end_interrupted(const std::string& how_far) {
  std::fflush(stdout);
  end(received, how_far);
  _exit(128 + received);
}

}  // namespace stiefel::cli
