#include "server/connections/self_watch.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>

#include <cerrno>
#include <memory>
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
  if (::connect(socket.get(), address.get(), address.length) == 0) return true;
  int fault = 0;
  socklen_t size = sizeof fault;
  return errno == EINPROGRESS && ready(socket, POLLOUT, until) &&
         getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &fault, &size) == 0 && fault == 0;
}

}  // namespace

std::string client_hello() {
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  &SSL_CTX_free);
  if (!context) return {};
  const std::unique_ptr<SSL, decltype(&SSL_free)> connection(SSL_new(context.get()), &SSL_free);
  if (!connection) return {};
  BIO* const out = BIO_new(BIO_s_mem());
  SSL_set_bio(connection.get(), BIO_new(BIO_s_mem()), out);  // takes ownership of both
  constexpr unsigned char http2[] = {2, 'h', '2'};
  SSL_set_alpn_protos(connection.get(), http2, sizeof http2);
  SSL_set_connect_state(connection.get());
  SSL_do_handshake(connection.get());  // stops to wait for the server's answer
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(out, &bytes);
  ERR_clear_error();
  return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : std::string();
}

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
      answered_(addresses_.size(), SteadyClock::now()),
      thread_("self-watch", patience / 5, [this](const auto& stop) { look(stop); }) {}

void SelfWatch::look(const std::stop_token& stop) {
  if (given_up_) return;
  for (std::size_t i = 0; i < addresses_.size() && !given_up_; ++i) {
    const bool plain = addresses_[i].storage.ss_family == AF_UNIX;
    if (answers(addresses_[i], patience_ / 5, plain ? std::string_view() : tls_hello_))
      answered_[i] = SteadyClock::now();
    if (stop.stop_requested()) return;
    given_up_ = SteadyClock::now() - answered_[i] >= patience_;
  }
  if (given_up_) give_up_();
}

}  // namespace stiefel::server
