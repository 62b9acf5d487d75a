#pragma once

#include <grpcpp/server_context.h>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/list_hook.hpp>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/connections/watched_files.h"
#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {

/// The tokens that a server accepts, each as its SHA-256: reading this object or its file yields no
/// token with which to call.
class TokenTable {
 public:
  struct Parsed;
  /// Parses the text of a token file: in each line a principal's name, 1 to 128 characters of
  /// [A-Za-z0-9._-], and 64 hexadecimal digits. Ignores empty lines and lines that begin with #. A
  /// principal may have several lines.
  static Parsed parse(std::string_view text);

  /// Returns the principal whose token has that digest; null if there is none.
  const Principal* find(const Bytes32& digest) const;
  std::size_t size() const { return principals_.size(); }

 private:
  struct Hash {
    std::size_t operator()(const Bytes32& digest) const;
  };
  struct Equal {
    bool operator()(const Bytes32& a, const Bytes32& b) const { return equal_secrets(a, b); }
  };
  std::unordered_map<Bytes32, Principal, Hash, Equal> principals_;
};

struct TokenTable::Parsed {
  TokenTable table;                 ///< the valid lines
  std::vector<std::string> faults;  ///< each gives the number of its line, never the text
};

/// A new token of 256 random bits, and the line for the file that admits it.
struct NewToken {
  std::string token;
  std::string line;
};
/// Throws std::runtime_error if `name` is not a valid name of a principal.
NewToken make_token(std::string_view name);

/// Returns the SHA-256 of the token in "Bearer TOKEN", the value of the metadata `authorization`;
/// nothing for a value of another form. The case of Bearer does not matter.
std::optional<Bytes32> digest_of_bearer(std::string_view authorization);

/// A call at a server with tokens, with its caller's principal, which `Callers` sets.
class AdmittedCall : public boost::intrusive::list_base_hook<> {
 public:
  const Principal& principal() const { return principal_; }

 private:
  friend class Callers;
  Principal principal_;
  Bytes32 digest_{};           // SHA-256 of the token
  grpc_call* call_ = nullptr;  // null: not admitted
};

/// Why a caller is refused.
enum class Refused { token_missing, token_unknown };

/// Decides who may call, by a file of tokens that is read again when it changes, and tracks the
/// calls that the tokens admitted. When a token is withdrawn, its calls end with UNAUTHENTICATED
/// and no new one begins. Thread-safe.
class Callers {
 public:
  /// A change of the file: the number of its tokens, and its invalid lines or why it cannot be
  /// read.
  struct Change {
    std::size_t tokens;
    std::vector<std::string> faults;
  };
  using Report = std::function<void(const Change&)>;

  /// Throws std::runtime_error if the file cannot be read or has an invalid line. Later, an invalid
  /// line admits nobody, and a file that cannot be read withdraws all tokens.
  Callers(const std::string& file, Report report);
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  /// Admits a call by its metadata `authorization` or returns the reason for refusing it. A call
  /// that was admitted stays so.
  std::optional<Refused> admit(grpc::ServerContextBase& context, AdmittedCall& call);
  /// Forgets a call, before it ends.
  void leave(AdmittedCall& call) noexcept {
    const std::lock_guard lock(mutex_);
    if (call.is_linked()) calls_.erase(calls_.iterator_to(call));
  }

 private:
  void take(const WatchedFiles::Contents& contents);
  void replace(TokenTable table);

  const Report report_;
  std::mutex mutex_;
  TokenTable table_;                            // guarded by mutex_
  boost::intrusive::list<AdmittedCall> calls_;  // guarded by mutex_; the admitted calls
  std::optional<WatchedFiles> watch_;
};

/// Returns the faults of a file of tokens, each with its line; empty for a valid file.
std::vector<std::string> faults_of_tokens(const std::string& file);

}  // namespace stiefel::server
