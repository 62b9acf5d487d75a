#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/sessions/identity.h"
#include "stiefel/price.h"

namespace stiefel::server {
namespace {

/// The sessions and the bytes of a page of ListSessions.
constexpr std::size_t default_page_size = 100, max_page_size = 1000, page_bytes = 2 << 20;

constexpr std::string_view digits = "0123456789abcdef";
constexpr std::size_t check_digits = 8;

std::string hexadecimal(std::string_view bytes) {
  std::string out;
  for (const char byte : bytes) {
    out += digits[static_cast<unsigned char>(byte) >> 4];
    out += digits[static_cast<unsigned char>(byte) & 0xF];
  }
  return out;
}

std::string check_of(std::string_view id) {
  const std::uint64_t value = hash(id);
  return hexadecimal({reinterpret_cast<const char*>(&value), sizeof value}).substr(0, check_digits);
}

/// Converts the last id of a page of ListSessions to an opaque token, and back; returns nothing for
/// a text that is not a token.
std::string page_token(std::string_view last_id) {
  return check_of(last_id) + hexadecimal(last_id);
}

std::optional<std::string> read_page_token(std::string_view token) {
  if (token.size() < check_digits || token.size() % 2 != 0) return std::nullopt;
  std::string id;
  for (std::size_t i = check_digits; i < token.size(); i += 2) {
    const std::size_t high = digits.find(token[i]), low = digits.find(token[i + 1]);
    if (high == digits.npos || low == digits.npos) return std::nullopt;
    id += static_cast<char>(16 * high + low);
  }
  if (token.substr(0, check_digits) != check_of(id)) return std::nullopt;
  return id;
}

}  // namespace

void ListSessions(ServerCall& call, const v1::ListSessionsRequest& request,
                  v1::ListSessionsResponse* response) {
  const std::optional<std::string> after =
      request.page_token().empty() ? "" : read_page_token(request.page_token());
  if (!after)
    throw errors::invalid("page_token", request.page_token(),
                          "must be the next_page_token of a reply of ListSessions");
  const std::size_t size = request.page_size() == 0
                               ? default_page_size
                               : std::min<std::size_t>(request.page_size(), max_page_size);
  // A list without scenes is never refused, so that a caller beyond the limits finds its sessions.
  const bool scenes = shows_scenes(request.view());
  if (scenes) call.hold(memory_price({.reply = page_bytes}));
  // One more session than asked for tells whether more follow.
  const Registry& registry = call.host().registry;
  const auto sessions = registry.page(call.principal(), *after, size + 1);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    v1::Session session;
    if (scenes)
      call.memory().grow_to(
          memory_price({.reply = page_bytes + array_bytes(sessions[i]->scene().description())}));
    if (i < size) to_list(*sessions[i], registry, request.view(), &session);
    bytes += session.ByteSizeLong();
    if (i == size || (i > 0 && bytes > page_bytes)) {
      response->set_next_page_token(page_token(sessions[i - 1]->id()));
      break;
    }
    *response->add_sessions() = std::move(session);
    call.pass();
  }
}

}  // namespace stiefel::server
