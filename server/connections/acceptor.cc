#include "server/connections/acceptor.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>


namespace stiefel::server {
namespace {

std::optional<ino_t> inode_of(int descriptor) {
  struct stat found;
  if (fstat(descriptor, &found) != 0) return std::nullopt;
  return found.st_ino;
}

using namespace std::chrono_literals;

/// The connections accepted in a row before other events are handled.
constexpr int accepted_at_once = 64;
/// Connections are recounted at most this often, since that costs a system call for each.
constexpr auto between_prunes = 10ms, between_reports = 1000ms;

Descriptor checked(int descriptor, const char* what) {
  if (descriptor < 0)
    throw std::runtime_error(std::string("no descriptor for ") + what + ": " +
                             std::strerror(errno));
  return Descriptor(descriptor);
}

Descriptor spare_descriptor() { return Descriptor(open("/dev/null", O_RDONLY | O_CLOEXEC)); }

/// Runs `work` and ignores its exceptions: without memory a connection is closed and the thread
/// goes on.
template <class Work>
void survive(const Work& work) {
  try {
    work();
  } catch (const std::exception&) {
  }
}

bool out_of_descriptors(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

/// Answers "HTTP/1.1 503 REASON" and closes the connection. gRPC's clients report that as
/// UNAVAILABLE and retry after growing pauses; after an HTTP/2 GOAWAY they would retry at once, a
/// thousand times a second. Never blocks: drops what the socket does not take at once.
void refuse_connection(Descriptor connection, std::string_view reason) {
  const std::string text = "HTTP/1.1 503 " + std::string(reason) +
                           "\r\ncontent-length: 0\r\nretry-after: 1\r\nconnection: close\r\n\r\n";
  send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  shutdown(connection.get(), SHUT_WR);
  // Closing with unread data would reset the connection before the client has read the answer.
  char unread[4096];
  while (recv(connection.get(), unread, sizeof unread, MSG_DONTWAIT) > 0) continue;
}

}  // namespace

void OpenConnections::add(int descriptor) {
  if (const auto inode = inode_of(descriptor)) open_.push_back({descriptor, *inode});
}

void OpenConnections::prune() {
  std::erase_if(open_, [](const Open& one) { return inode_of(one.descriptor) != one.inode; });
}

Acceptor::Acceptor(std::vector<Listener> listeners, Limits limits, GiveAway give_away,
                   Report report)
    : listeners_(std::move(listeners)),
      limits_(limits),
      give_away_(std::move(give_away)),
      report_(std::move(report)),
      events_(checked(epoll_create1(EPOLL_CLOEXEC), "epoll")),
      wake_(checked(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC), "an event")),
      spare_(spare_descriptor()) {
  watch(wake_.get());
  for (const Listener& listener : listeners_) watch(listener.socket.get());
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Acceptor::~Acceptor() {
  thread_.request_stop();
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

void Acceptor::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "accept");
  std::array<epoll_event, 64> ready;
  while (!stop.stop_requested()) {
    const int count = epoll_wait(events_.get(), ready.data(), ready.size(), milliseconds_to_wait());
    for (int i = 0; i < count; ++i)
      survive([&] { handle(ready[static_cast<std::size_t>(i)].data.fd); });
    survive([&] { drop_expired(); });
  }
}

void Acceptor::handle(int ready) {
  if (by_descriptor_.contains(ready))
    hear(ready);
  else if (ready != wake_.get())
    accept_from(ready);
}

void Acceptor::watch(int descriptor) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = descriptor;
  epoll_ctl(events_.get(), EPOLL_CTL_ADD, descriptor, &event);
}

void Acceptor::accept_from(int listener) {
  // `listener` may be the descriptor of a connection that was closed earlier in this round.
  if (std::ranges::none_of(listeners_,
                           [&](const Listener& one) { return one.socket.get() == listener; }))
    return;
  for (int i = 0; i < accepted_at_once; ++i) {
    Descriptor connection(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (connection) {
      take(std::move(connection));
    } else if (out_of_descriptors(errno)) {
      if (!drop_oldest_silent()) return refuse_without_descriptors(listener);
    } else if (errno != EINTR && errno != ECONNABORTED) {
      return;
    }
  }
}

void Acceptor::take(Descriptor connection) {
  if (open() + silent_.size() >= limits_.most + waiting_room) drop_oldest_silent();
  const int descriptor = connection.get();
  std::list<Silent> newest;
  newest.push_back({std::move(connection), Clock::now() + limits_.patience});
  by_descriptor_[descriptor] = newest.begin();
  silent_.splice(silent_.end(), newest);
  watch(descriptor);
}

Descriptor Acceptor::forget(int descriptor) {
  const auto one = by_descriptor_.extract(descriptor).mapped();
  epoll_ctl(events_.get(), EPOLL_CTL_DEL, descriptor, nullptr);
  Descriptor connection = std::move(one->connection);
  silent_.erase(one);
  return connection;
}

/// Gives a connection away, or refuses it, when bytes have come, and closes it at its end. Does
/// nothing if the event was of an earlier connection with this descriptor.
void Acceptor::hear(int descriptor) {
  char byte;
  const ssize_t got = recv(descriptor, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return;
  Descriptor connection = forget(descriptor);
  if (got != 1) return;
  if (open() >= limits_.most) return refuse(std::move(connection), "too many connections");
  open_.add(descriptor);
  give_away_(connection.release());
}

bool Acceptor::drop_oldest_silent() {
  if (silent_.empty()) return false;
  const int oldest = silent_.front().connection.get();
  hear(oldest);  // gives it away if it has spoken by now
  if (by_descriptor_.contains(oldest)) forget(oldest);
  return true;
}

std::size_t Acceptor::open() {
  const bool matters = open_.at_most() + silent_.size() >= limits_.most;
  if (const auto now = Clock::now(); matters && now - pruned_ >= between_prunes) {
    open_.prune();
    pruned_ = now;
  }
  return open_.at_most();
}

void Acceptor::refuse(Descriptor connection, std::string_view reason) {
  refuse_connection(std::move(connection), reason);
  ++refused_;
  const auto now = Clock::now();
  if (now - reported_ < between_reports) return;
  reported_ = now;
  report_(std::exchange(refused_, 0));
}

void Acceptor::refuse_without_descriptors(int listener) {
  spare_.reset();
  Descriptor connection(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (connection)
    refuse(std::move(connection), "the server has no file descriptor left");
  else
    std::this_thread::sleep_for(between_prunes);  // another thread took the descriptor
  spare_ = spare_descriptor();
}

int Acceptor::milliseconds_to_wait() const {
  if (silent_.empty()) return -1;
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(silent_.front().until - Clock::now());
  return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
}

}  // namespace stiefel::server
