#include "server/transport/refusal.h"

#include <sys/socket.h>

#include <string>

namespace stiefel::server {

void refuse_connection(Descriptor connection, std::string_view reason) {
  const std::string text = "HTTP/1.1 503 " + std::string(reason) +
                           "\r\ncontent-length: 0\r\nretry-after: 1\r\nconnection: close\r\n\r\n";
  send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  shutdown(connection.get(), SHUT_WR);
  // Closing with unread data would reset the connection before the client has read the answer.
  char unread[4096];
  while (recv(connection.get(), unread, sizeof unread, MSG_DONTWAIT) > 0) continue;
}

}  // namespace stiefel::server
