#include "server/connections/callers.h"

#include <grpc/grpc.h>
#include <strings.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {
namespace {

constexpr const char* rule_of_names = "a name must have 1 to 128 characters of [A-Za-z0-9._-]";
/// The prefix by which a search of public text finds a token that leaked.
constexpr const char* mark = "stiefel_";

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= 128 && std::ranges::all_of(name, [](unsigned char c) {
    return c < 128 && (std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-');
  });
}

bool is_digest(std::string_view digits) {
  return digits.size() == 64 &&
         std::ranges::all_of(digits, [](unsigned char c) { return std::isxdigit(c) != 0; });
}

}  // namespace

ParsedTokens parse_tokens(const std::string& text) {
  ParsedTokens parsed;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string name, digits, more;
    words >> name >> digits >> more;
    if (name.empty() || name.front() == '#') continue;
    std::ranges::transform(digits, digits.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto fault = [&](const char* rule) {
      parsed.faults.push_back("line " + std::to_string(number) + ": " + rule);
    };
    if (!is_name(name))
      fault(rule_of_names);
    else if (!is_digest(digits) || !more.empty())
      fault("after the name there must be 64 hexadecimal digits, as `stiefel-server token` prints");
    else if (!parsed.table.emplace(digits, Principal{name}).second)
      fault("another line has this token");
  }
  return parsed;
}

NewToken make_token(const std::string& name) {
  if (!is_name(name)) throw std::runtime_error(rule_of_names);
  const std::string token = mark + to_hexadecimal(random_secret());
  return {token, name + ' ' + to_hexadecimal(sha256(token))};
}

std::optional<std::string> digest_of_bearer(const std::string& authorization) {
  std::istringstream words(authorization);
  std::string scheme, token, more;
  words >> scheme >> token >> more;
  if (strcasecmp(scheme.c_str(), "bearer") != 0 || token.empty() || !more.empty())
    return std::nullopt;
  return to_hexadecimal(sha256(token));
}

Callers::Callers(const std::string& file, const Log& log) {
  file_.emplace(std::vector{file}, log, "tokens", [this, file](const auto& contents) {
    auto parsed = contents[0] ? parse_tokens(*contents[0]) : ParsedTokens();
    if (!contents[0]) parsed.faults.push_back(contents[0].error());
    replace(std::move(parsed.table));
    if (parsed.faults.empty()) return;
    const std::size_t more = parsed.faults.size() - 1;
    throw std::runtime_error("--tokens: " + file + ": " + parsed.faults.front() +
                             (more > 0 ? "; and " + std::to_string(more) + " more" : ""));
  });
}

std::expected<Principal, Refused> Callers::admit(grpc::ServerContext& context) {
  const auto& metadata = context.client_metadata();
  const auto [first, last] = metadata.equal_range("authorization");
  if (first == last) return std::unexpected(Refused::token_missing);
  const auto digest = digest_of_bearer({first->second.data(), first->second.size()});
  if (!digest || std::next(first) != last) return std::unexpected(Refused::token_unknown);
  const std::lock_guard lock(mutex_);
  const auto found = table_.find(*digest);
  if (found == table_.end()) return std::unexpected(Refused::token_unknown);
  calls_.insert_or_assign(&context, Admitted{*digest, found->second, context.c_call()});
  return found->second;
}

void Callers::replace(TokenTable table) {
  const std::lock_guard lock(mutex_);
  table_ = std::move(table);
  for (const auto& [context, admitted] : calls_) {
    const auto found = table_.find(admitted.digest);
    if (found == table_.end() || found->second != admitted.principal)
      grpc_call_cancel_with_status(admitted.call, GRPC_STATUS_UNAUTHENTICATED,
                                   "the token was withdrawn", nullptr);
  }
}

}  // namespace stiefel::server
