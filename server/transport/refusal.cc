#include "server/transport/refusal.h"

#include <sys/socket.h>

#include <cstdint>
#include <string>

namespace stiefel::server {
namespace {

// RFC 9113, sections 4.1, 6.5, 6.8 and 7.
constexpr std::uint8_t settings = 0x4, goaway = 0x7;
constexpr std::uint32_t enhance_your_calm = 0xb;

void append(std::string& out, std::uint32_t value, int bytes) {
  while (bytes-- > 0) out += static_cast<char>(value >> (8 * bytes) & 0xff);
}

/// A frame of stream 0 without flags.
std::string frame(std::uint8_t type, std::string_view payload) {
  std::string out;
  append(out, static_cast<std::uint32_t>(payload.size()), 3);
  append(out, type, 1);
  append(out, 0, 1);
  append(out, 0, 4);
  return out.append(payload);
}

std::string farewell(std::string_view reason) {
  std::string payload;
  append(payload, 0, 4);  // no stream was served
  append(payload, enhance_your_calm, 4);
  return frame(settings, {}) + frame(goaway, payload.append(reason));
}

}  // namespace

void refuse_connection(Descriptor connection, std::string_view reason) {
  const std::string text = farewell(reason);
  send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  shutdown(connection.get(), SHUT_WR);
  // Closing with unread data would reset the connection before the client reads why.
  char unread[4096];
  while (recv(connection.get(), unread, sizeof unread, MSG_DONTWAIT) > 0) continue;
}

}  // namespace stiefel::server
