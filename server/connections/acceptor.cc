#include "server/connections/acceptor.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

constexpr auto between_reports = 1s;
/// The wait in milliseconds after the process had no descriptor for a connection. The connection
/// stays in the kernel's queue.
constexpr int pause = 100;

Descriptor event() {
  Descriptor event(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!event) throw std::runtime_error(std::string("no descriptor: ") + std::strerror(errno));
  return event;
}

}  // namespace

Acceptor::Acceptor(std::vector<Listener> listeners, int most, GiveAway give_away, Report report)
    : listeners_(std::move(listeners)),
      most_(most),
      give_away_(std::move(give_away)),
      report_(std::move(report)),
      wake_(event()),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Acceptor::~Acceptor() {
  thread_.request_stop();
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

void Acceptor::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "accept");
  std::vector<pollfd> ready = {{wake_.get(), POLLIN, 0}};
  for (const Listener& one : listeners_) ready.push_back({one.socket.get(), POLLIN, 0});
  while (!stop.stop_requested()) {
    poll(ready.data(), ready.size(), -1);
    bool accepted = true;
    for (const pollfd& one : ready)
      if (one.revents != 0 && one.fd != wake_.get()) accepted &= accept_from(one.fd);
    if (!accepted) poll(ready.data(), 1, pause);
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
  const auto now = Clock::now();
  if (now - reported_ < between_reports) return;
  reported_ = now;
  report_(std::exchange(refused_, 0));
}

}  // namespace stiefel::server
