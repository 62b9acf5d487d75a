#include "server/transport/self_watch.h"

#include <poll.h>

#include <cerrno>
#include <string_view>

namespace stiefel::server {
namespace {

using SteadyClock = std::chrono::steady_clock;
using namespace std::string_view_literals;

/// The client's preface and its empty SETTINGS frame (RFC 9113, section 3.4).
constexpr auto preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0"sv;
constexpr std::size_t frame_header = 9;

bool ready(const Descriptor& socket, short events, SteadyClock::time_point until) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - SteadyClock::now());
  pollfd one{socket.get(), events, 0};
  return left.count() > 0 && poll(&one, 1, static_cast<int>(left.count())) == 1;
}

bool connected(const Descriptor& socket, const SocketAddress& address,
               SteadyClock::time_point until) {
  if (connect(socket.get(), address.get(), address.length) == 0) return true;
  int fault = 0;
  socklen_t size = sizeof fault;
  return errno == EINPROGRESS && ready(socket, POLLOUT, until) &&
         getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &fault, &size) == 0 && fault == 0;
}

}  // namespace

bool answers(const SocketAddress& address, std::chrono::milliseconds timeout,
             std::string_view hello) {
  if (hello.empty()) hello = preface;
  const auto until = SteadyClock::now() + timeout;
  const Descriptor socket(
      ::socket(address.storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return true;
  if (!connected(socket, address, until)) return false;
  send(socket.get(), hello.data(), hello.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  std::size_t received = 0;
  while (received < frame_header && ready(socket, POLLIN, until)) {
    char bytes[64];
    const ssize_t got = recv(socket.get(), bytes, sizeof bytes, MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) break;
    if (got > 0) received += static_cast<std::size_t>(got);
  }
  return received >= frame_header;
}

SelfWatch::SelfWatch(std::vector<SocketAddress> addresses, std::chrono::milliseconds patience,
                     std::function<void()> give_up, std::string tls_hello)
    : addresses_(std::move(addresses)),
      patience_(patience),
      give_up_(std::move(give_up)),
      tls_hello_(std::move(tls_hello)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void SelfWatch::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "self-watch");
  const auto pause = patience_ / 5;
  std::vector<SteadyClock::time_point> answered(addresses_.size(), SteadyClock::now());
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
    for (std::size_t i = 0; i < addresses_.size(); ++i) {
      const bool plain = addresses_[i].storage.ss_family == AF_UNIX;
      if (answers(addresses_[i], pause, plain ? std::string_view() : tls_hello_))
        answered[i] = SteadyClock::now();
      if (stop.stop_requested()) return;
      if (SteadyClock::now() - answered[i] >= patience_) return give_up_();
    }
  }
}

}  // namespace stiefel::server
