#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <thread>
#include <unordered_map>
#include <vector>

#include "server/transport/listener.h"
#include "server/transport/open_connections.h"

namespace stiefel::server {

/// The thread that accepts connections and gives each away once it has sent its first byte, which
/// an HTTP/2 client does unasked. A connection that says nothing costs a descriptor and no more:
/// it is closed after `patience`, or earlier, the oldest first, when its place is needed. When
/// `most` connections that spoke are open, the next one that speaks is told so and closed; when no
/// descriptor is left, the next one at once. The listener stays.
class Acceptor {
 public:
  struct Limits {
    std::size_t most = 1;  ///< connections given away at once
    std::chrono::milliseconds patience = std::chrono::seconds(10);
  };
  /// Silent connections beyond `most`: room to hear a new one, if only to refuse it.
  static constexpr std::size_t waiting_room = 32;
  /// Takes a connection, which does not block, and closes it some time.
  using GiveAway = std::function<void(int connection)>;
  /// Hears, at most once a second, how many connections were refused since the last time.
  using Report = std::function<void(std::size_t refused)>;

  /// Throws std::runtime_error where the system gives no descriptor.
  Acceptor(std::vector<Listener> listeners, Limits limits, GiveAway give_away, Report report);
  /// Stops listening, removes the files of Unix sockets, closes what has not spoken.
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
  /// Of the silent ones.
  Descriptor forget(int descriptor);
  bool drop_oldest_silent();
  void drop_expired();
  /// The connections given away that are open, or at most as many as the last 10 ms closed more.
  std::size_t open();
  void refuse(Descriptor connection, std::string_view reason);
  void refuse_without_descriptors(int listener);
  int milliseconds_to_wait() const;

  const std::vector<Listener> listeners_;
  const Limits limits_;
  const GiveAway give_away_;
  const Report report_;
  Descriptor events_;         // epoll
  Descriptor wake_;           // readable when the thread is to end
  Descriptor spare_;          // closed to accept, and refuse, when there is no other
  std::list<Silent> silent_;  // the oldest first
  std::unordered_map<int, std::list<Silent>::iterator> by_descriptor_;
  OpenConnections open_;
  Clock::time_point pruned_{}, reported_{};
  std::size_t refused_ = 0;
  std::jthread thread_;
};

}  // namespace stiefel::server
