#include "server/connections/acceptor.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <exception>
#include <utility>

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

constexpr auto between_reports = 1s;
/// The wait after the process had no descriptor for a connection, which stays in the kernel's
/// queue.
constexpr auto pause = 100ms;

}  // namespace

Acceptor::Acceptor(std::vector<Listener> listeners, int most, GiveAway give_away, const Log& log)
    : listeners_(std::move(listeners)),
      most_(most),
      give_away_(std::move(give_away)),
      log_(log),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Acceptor::~Acceptor() {
  thread_.request_stop();
  for (const Listener& one : listeners_) shutdown(one.socket.get(), SHUT_RDWR);  // wakes poll
  thread_.join();
}

void Acceptor::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "accept");
  std::vector<pollfd> ready;
  for (const Listener& one : listeners_) ready.push_back({one.socket.get(), POLLIN, 0});
  while (!stop.stop_requested()) {
    if (poll(ready.data(), ready.size(), -1) <= 0) continue;
    bool accepted = true;
    for (const pollfd& one : ready)
      if (one.revents != 0) accepted &= accept_from(one.fd);
    if (!accepted) std::this_thread::sleep_for(pause);
  }
}

bool Acceptor::accept_from(int listener) {
  Descriptor connection(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (!connection) return errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM;
  try {
    connection.get() < most_ ? give_away_(connection.release()) : refuse();
  } catch (const std::exception&) {  // no memory: the connection is closed and the thread goes on
  }
  return true;
}

void Acceptor::refuse() {
  ++refused_;
  const auto now = std::chrono::steady_clock::now();
  if (now - reported_ < between_reports) return;
  reported_ = now;
  log_.line(Log::Level::warn, "connections refused", {{"count", std::exchange(refused_, 0)}});
}

}  // namespace stiefel::server
