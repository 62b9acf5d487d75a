#include "server/metrics/trace_id.h"

#include <algorithm>

namespace stiefel::server {
namespace {

constexpr std::size_t length = 55;  // of a header of version 00

bool is_hex(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool is_id(std::string_view text) {
  return is_hex(text) && text.find_first_not_of('0') != std::string_view::npos;
}

}  // namespace

std::string_view trace_id(std::string_view header) {
  if (header.size() < length) return {};
  const std::string_view version = header.substr(0, 2), trace = header.substr(3, 32),
                         parent = header.substr(36, 16), flags = header.substr(53, 2);
  const bool dashes = header[2] == '-' && header[35] == '-' && header[52] == '-';
  const bool end = header.size() == length || (version != "00" && header[length] == '-');
  const bool sound = dashes && end && is_hex(version) && version != "ff" && is_id(trace) &&
                     is_id(parent) && is_hex(flags);
  return sound ? trace : std::string_view();
}

}  // namespace stiefel::server
