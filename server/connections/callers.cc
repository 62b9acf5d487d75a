#include "server/connections/callers.h"

#include <grpc/grpc.h>
#include <strings.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <sstream>
#include <stdexcept>
#include <utility>

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

TokenTable checked(const std::string& file, const WatchedFiles::Contents& contents) {
  const auto fault = [&](const std::string& what) {
    throw std::runtime_error("--tokens: " + file + ": " + what);
  };
  if (!contents[0]) fault(contents[0].error());
  auto parsed = TokenTable::parse(*contents[0]);
  if (!parsed.faults.empty()) fault(parsed.faults.front());
  return std::move(parsed.table);
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
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string name, digits, more;
    words >> name >> digits >> more;
    if (name.empty() || name.starts_with('#')) continue;
    const auto fault = [&](const std::string& rule) {
      parsed.faults.push_back("line " + std::to_string(number) + ": " + rule);
    };
    const auto digest = more.empty() ? from_hexadecimal(digits) : std::nullopt;
    if (!is_name(name))
      fault(rule_of_names);
    else if (!digest)
      fault("after the name there must be 64 hexadecimal digits, as `stiefel-server token` prints");
    else if (!parsed.table.principals_.emplace(*digest, Principal{name}).second)
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
  constexpr std::string_view scheme = "bearer", space = " \t";
  const auto skip_space = [&] {
    authorization.remove_prefix(
        std::min(authorization.find_first_not_of(space), authorization.size()));
  };
  skip_space();
  const std::string_view given = authorization.substr(0, authorization.find_first_of(space));
  if (given.size() != scheme.size() || strncasecmp(given.data(), scheme.data(), given.size()) != 0)
    return std::nullopt;
  authorization.remove_prefix(given.size());
  skip_space();
  if (authorization.empty()) return std::nullopt;
  return sha256(authorization.substr(0, authorization.find_last_not_of(space) + 1));
}

Callers::Callers(const std::string& file, Report report) : report_(std::move(report)) {
  const auto contents = read_texts({file});
  table_ = checked(file, contents);
  watch_.emplace(std::vector{file}, contents,
                 [this](const WatchedFiles::Contents& changed) { take(changed); });
}

std::optional<Refused> Callers::admit(grpc::ServerContextBase& context, AdmittedCall& call) {
  if (call.call_ != nullptr) return std::nullopt;
  const auto& metadata = context.client_metadata();
  if (!metadata.contains("authorization")) return Refused::token_missing;
  const auto [first, last] = metadata.equal_range("authorization");
  const auto digest = digest_of_bearer({first->second.data(), first->second.size()});
  if (!digest || std::next(first) != last) return Refused::token_unknown;
  const std::lock_guard lock(mutex_);
  const Principal* principal = table_.find(*digest);
  if (principal == nullptr) return Refused::token_unknown;
  call.principal_ = *principal;
  call.digest_ = *digest;
  call.call_ = context.c_call();
  calls_.push_back(call);
  return std::nullopt;
}

void Callers::take(const WatchedFiles::Contents& contents) {
  if (!contents[0]) {
    replace({});
    return report_({0, {contents[0].error() + ": every call is refused"}});
  }
  auto parsed = TokenTable::parse(*contents[0]);
  const std::size_t tokens = parsed.table.size();
  replace(std::move(parsed.table));
  report_({tokens, std::move(parsed.faults)});
}

void Callers::replace(TokenTable table) {
  std::vector<grpc_call*> withdrawn;
  {
    const std::lock_guard lock(mutex_);
    table_ = std::move(table);
    for (AdmittedCall& call : calls_) {
      const Principal* principal = table_.find(call.digest_);
      if (principal != nullptr && *principal == call.principal_) continue;
      // A call leaves, or gRPC releases its context, before gRPC frees it: so it still exists.
      grpc_call_ref(call.call_);
      withdrawn.push_back(call.call_);
    }
  }
  // Cancels without the lock: a cancellation may release contexts on this thread.
  for (grpc_call* call : withdrawn) {
    grpc_call_cancel_with_status(call, GRPC_STATUS_UNAUTHENTICATED, "the token was withdrawn",
                                 nullptr);
    grpc_call_unref(call);
  }
}

std::vector<std::string> faults_of_tokens(const std::string& file) {
  const auto text = read_text(file);
  if (!text) return {text.error()};
  return TokenTable::parse(*text).faults;
}

}  // namespace stiefel::server
