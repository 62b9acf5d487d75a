#include "server/connections/address.h"

#include <arpa/inet.h>
#include <sys/un.h>

#include <algorithm>
#include <charconv>
#include <regex>

namespace stiefel::server {
namespace {

constexpr std::size_t longest_path = sizeof(sockaddr_un::sun_path) - 1;
constexpr std::size_t longest_host = 253;
constexpr int largest_port = 65535;

bool is_ip(int family, std::string_view host) {
  unsigned char address[sizeof(in6_addr)];
  return inet_pton(family, std::string(host).c_str(), address) == 1;
}

/// Whether a host is a name: labels of letters, digits, '-' and '_' with dots between them, the
/// last label not of digits only, which only IPv4 addresses have.
bool is_host_name(std::string_view host) {
  static const std::regex name(
      "([A-Za-z0-9_]([A-Za-z0-9_-]*[A-Za-z0-9_])?\\.)*"
      "(?![0-9]+\\.?$)[A-Za-z0-9_]([A-Za-z0-9_-]*[A-Za-z0-9_])?\\.?");
  return host.size() <= longest_host && std::regex_match(host.begin(), host.end(), name);
}

bool is_host(std::string_view host) {
  if (!host.starts_with('[')) return is_ip(AF_INET, host) || is_host_name(host);
  if (!host.ends_with(']')) return false;
  host = host.substr(1, host.size() - 2);
  return is_ip(AF_INET6, host.substr(0, host.find('%')));
}

bool is_port(std::string_view port) {
  int value = -1;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), value);
  return error == std::errc() && end == port.data() + port.size() && value >= 0 &&
         value <= largest_port && port.front() != '-';
}

std::optional<std::string> path_fault(std::string_view path) {
  if (path.empty()) return "must have a path after unix:";
  if (path.size() > longest_path)
    return "the path of " + std::to_string(path.size()) + " bytes must have at most " +
           std::to_string(longest_path);
  return std::nullopt;
}

}  // namespace

bool is_unix(std::string_view address) { return address.starts_with("unix:"); }

std::string_view unix_path(std::string_view address) {
  address.remove_prefix(5);
  if (address.starts_with("///")) address.remove_prefix(2);
  return address;
}

std::optional<std::string> address_fault(std::string_view address) {
  if (is_unix(address)) return path_fault(unix_path(address));
  const std::size_t colon = address.rfind(':');
  const bool in_brackets = address.find(']', std::min(colon, address.size())) != address.npos;
  if (colon == address.npos || in_brackets) return "has no port: must be host:port or unix:PATH";
  const std::string host(address.substr(0, colon)), port(address.substr(colon + 1));
  if (!is_port(port))
    return "the port '" + port + "' must be a number from 0 to " + std::to_string(largest_port);
  if (is_ip(AF_INET6, host))
    return "the host '" + host + "' is an IPv6 address and must be in brackets";
  if (!is_host(host))
    return "the host '" + host + "' must be a name, an IPv4 address or an IPv6 address in brackets";
  return std::nullopt;
}

}  // namespace stiefel::server
