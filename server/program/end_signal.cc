#include "server/program/end_signal.h"

#include <poll.h>
#include <pthread.h>
#include <unistd.h>

#include <sstream>
#include <string_view>
#include <thread>

namespace stiefel::server {
namespace {

/// The time beyond the grace period that the process gets to end by itself.
constexpr auto last_resort = std::chrono::milliseconds(1900);

/// Writes a line of less than PIPE_BUF bytes to stderr, unless that would block for longer than
/// 100 ms: on a pipe that nobody reads.
void write_stderr(std::string_view line) {
  pollfd descriptor{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&descriptor, 1, 100) > 0)
    static_cast<void>(write(STDERR_FILENO, line.data(), line.size()) > 0);
}

}  // namespace

EndSignal::EndSignal(std::chrono::milliseconds grace) : grace_(grace) {
  // Every thread inherits the mask, so that only sigwait sees the signals.
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  std::thread([this] { receive(); }).detach();
}

void EndSignal::receive() {
  int received = 0;
  sigwait(&signals_, &received);
  if (starting_.exchange(false)) {
    write_stderr("stiefel-server: ends before it has started\n");
    _exit(0);
  }
  std::thread([this] { exit_in_time(); }).detach();
  received_.count_down();
}

/// Sleeps in five parts: a part during which the whole machine stood still counts as a fifth of the
/// time, so that a shutdown is not given up before it could run.
void EndSignal::exit_in_time() {
  constexpr int parts = 5;
  const auto time = grace_ + last_resort;
  for (int part = 0; part < parts; ++part) std::this_thread::sleep_for(time / parts);
  std::ostringstream said;
  said << "stiefel-server: ends " << std::chrono::duration<double>(time).count()
       << " s after the signal without waiting any longer for " << waits_for_ << '\n';
  write_stderr(said.str());
  _exit(0);
}

void EndSignal::exit_soon() {
  std::thread([] {
    std::this_thread::sleep_for(last_resort / 4);
    _exit(0);
  }).detach();
}

}  // namespace stiefel::server
