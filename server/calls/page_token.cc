#include "server/calls/page_token.h"

#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

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

}  // namespace

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

}  // namespace stiefel::server
