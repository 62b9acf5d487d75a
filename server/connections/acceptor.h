#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/connections/listener.h"

namespace stiefel::server {

/// Counts connections whose descriptors another owner closes without notice. A descriptor is still
/// the connection that was added while its inode is the same, because the kernel gives every socket
/// a new one.
class OpenConnections {
 public:
  void add(int descriptor);
  /// The most connections that can be open; some may have been closed since the last `prune`.
  std::size_t at_most() const { return open_.size(); }
  /// Forgets the closed connections; costs one fstat each.
  void prune();

 private:
  struct Open {
    int descriptor;
    ino_t inode;
  };
  std::vector<Open> open_;
};

/// Accepts connections on a thread of its own and gives each one away once it has sent its first
/// byte, which an HTTP/2 client does unasked. A connection that is silent costs only a descriptor;
/// it is closed after `patience`, or earlier, oldest first, when its place is needed. A connection
/// that speaks while `most` others are given away and open is refused with a reason and closed;
/// without a free descriptor, the next connection is refused at once. The listeners stay open.
class Acceptor {
 public:
  struct Limits {
    std::size_t most = 1;  ///< the most connections given away and open
    std::chrono::milliseconds patience = std::chrono::seconds(10);
  };
  /// The silent connections allowed beyond `most`, so that a new one can be heard, if only to
  /// refuse it.
  static constexpr std::size_t waiting_room = 32;
  /// Takes over a non-blocking connection and closes it in the end.
  using GiveAway = std::function<void(int connection)>;
  /// Is called at most once a second with the number of connections refused since the last call.
  using Report = std::function<void(std::size_t refused)>;

  /// Throws std::runtime_error if the system gives no descriptor.
  Acceptor(std::vector<Listener> listeners, Limits limits, GiveAway give_away, Report report);
  /// Stops listening, removes the files of Unix sockets and closes the silent connections.
  ~Acceptor();
  Acceptor(const Acceptor&) = delete;
  Acceptor& operator=(const Acceptor&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  struct Silent {
    Descriptor connection;
    Clock::time_point until;
  };

  void run(const std::stop_token& stop);
  void handle(int ready);
  void watch(int descriptor);
  void accept_from(int listener);
  void take(Descriptor connection);
  void hear(int descriptor);
  /// Removes a connection from the silent ones and returns it.
  Descriptor forget(int descriptor);
  bool drop_oldest_silent();
  void drop_expired() {
    const auto now = Clock::now();
    while (!silent_.empty() && silent_.front().until <= now) drop_oldest_silent();
  }
  /// Returns how many connections given away are open; too many by at most those closed in the last
  /// 10 ms.
  std::size_t open();
  void refuse(Descriptor connection, std::string_view reason);
  void refuse_without_descriptors(int listener);
  int milliseconds_to_wait() const;

  const std::vector<Listener> listeners_;
  const Limits limits_;
  const GiveAway give_away_;
  const Report report_;
  Descriptor events_;         // epoll
  Descriptor wake_;           // readable when the thread should end
  Descriptor spare_;          // closed to accept, and refuse, when no other is left
  std::list<Silent> silent_;  // oldest first
  std::unordered_map<int, std::list<Silent>::iterator> by_descriptor_;
  OpenConnections open_;
  Clock::time_point pruned_{}, reported_{};
  std::size_t refused_ = 0;
  std::jthread thread_;
};

}  // namespace stiefel::server
