#include "server/connections/tokens.h"

#include <strings.h>

#include <cstring>
#include <stdexcept>

#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {
namespace {

constexpr std::size_t longest_name = 128;
constexpr const char* rule_of_names = "a name must have 1 to 128 characters of [A-Za-z0-9._-]";
/// The prefix by which a search of public text finds a token that leaked.
constexpr std::string_view mark = "stiefel_";

bool is_name(std::string_view name) {
  constexpr std::string_view allowed =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
  return !name.empty() && name.size() <= longest_name &&
         name.find_first_not_of(allowed) == name.npos;
}

}  // namespace

/// Uses the first bytes of the digest, which reveal nothing of a token of 256 random bits.
std::size_t TokenTable::Hash::operator()(const Bytes32& digest) const {
  std::size_t value;
  std::memcpy(&value, digest.data(), sizeof value);
  return value;
}

TokenTable::Parsed TokenTable::parse(std::string_view text) {
  Parsed parsed;
  for (Line line : meaningful_lines(text)) {
    const auto fault = [&](const std::string& rule) {
      parsed.faults.push_back("line " + std::to_string(line.number) + ": " + rule);
    };
    const std::string_view name = next_word(line.text);
    const auto digest = from_hexadecimal(line.text);
    if (!is_name(name))
      fault(rule_of_names);
    else if (!digest)
      fault("after the name there must be 64 hexadecimal digits, as `stiefel-server token` prints");
    else if (!parsed.table.principals_.emplace(*digest, Principal{std::string(name)}).second)
      fault("another line has this token");
  }
  return parsed;
}

const Principal* TokenTable::find(const Bytes32& digest) const {
  const auto found = principals_.find(digest);
  return found == principals_.end() ? nullptr : &found->second;
}

NewToken make_token(std::string_view name) {
  if (!is_name(name)) throw std::runtime_error(rule_of_names);
  const std::string token = std::string(mark) + to_hexadecimal(random_secret());
  return {token, std::string(name) + ' ' + to_hexadecimal(sha256(token))};
}

std::optional<Bytes32> digest_of_bearer(std::string_view authorization) {
  const std::string_view scheme = next_word(authorization);
  if (scheme.size() != 6 || strncasecmp(scheme.data(), "bearer", 6) != 0 || authorization.empty())
    return std::nullopt;
  return sha256(authorization);
}

}  // namespace stiefel::server
