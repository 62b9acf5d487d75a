#pragma once

#include <grpcpp/server_context.h>

#include <expected>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/connections/log.h"
#include "server/connections/watched_files.h"
#include "server/scheduling/principal.h"

namespace stiefel::server {

/// The principals that may call, each by the SHA-256 of its token in hexadecimal digits: reading
/// the table or its file yields no token with which to call.
using TokenTable = std::unordered_map<std::string, Principal>;

struct ParsedTokens {
  TokenTable table;                 ///< the valid lines
  std::vector<std::string> faults;  ///< each gives the number of its line, never the text
};
/// Parses the text of a token file: in each line a principal's name, 1 to 128 characters of
/// [A-Za-z0-9._-], and 64 hexadecimal digits. Ignores empty lines and lines that begin with #. A
/// principal may have several lines.
ParsedTokens parse_tokens(const std::string& text);

/// A new token of 256 random bits, and the line for the file that admits it.
struct NewToken {
  std::string token;
  std::string line;
};
/// Throws std::runtime_error if `name` is not a valid name of a principal.
NewToken make_token(const std::string& name);

/// Returns the SHA-256 of the token in "Bearer TOKEN", the value of the metadata `authorization`;
/// nothing for a value of another form. The case of Bearer does not matter.
std::optional<std::string> digest_of_bearer(const std::string& authorization);

/// Why a caller is refused.
enum class Refused { token_missing, token_unknown };

/// Decides who may call, by a file of tokens that is read again when it changes, and tracks the
/// calls that the tokens admitted. When a token is withdrawn, its calls end with UNAUTHENTICATED
/// and no new one begins. Thread-safe.
class Callers {
 public:
  /// Throws std::runtime_error if the file cannot be read or has an invalid line. Later, an invalid
  /// line admits nobody, a file that cannot be read withdraws all tokens, and the log says so.
  Callers(const std::string& file, const Log& log);
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  /// Returns the principal of a call by its metadata `authorization`, or the reason for refusing
  /// it.
  std::expected<Principal, Refused> admit(grpc::ServerContext& context);
  /// Forgets a call, admitted or not, before it ends.
  void leave(const grpc::ServerContext& context) noexcept {
    const std::lock_guard lock(mutex_);
    calls_.erase(&context);
  }

 private:
  struct Admitted {
    std::string digest;  // of the token
    Principal principal;
    grpc_call* call;
  };

  void replace(TokenTable table);

  std::mutex mutex_;
  TokenTable table_;                                                // guarded by mutex_
  std::unordered_map<const grpc::ServerContext*, Admitted> calls_;  // guarded by mutex_
  std::optional<WatchedFiles> file_;
};

}  // namespace stiefel::server
