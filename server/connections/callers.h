#pragma once

#include <grpcpp/server_context.h>
#include <boost/intrusive/list.hpp>
#include <boost/intrusive/list_hook.hpp>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/connections/tokens.h"
#include "server/connections/watched_files.h"
#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {

/// The context of a call at a server with tokens, with the caller's principal, which `Callers`
/// sets.
class CallerContext final : public grpc::CallbackServerContext,
                            public boost::intrusive::list_base_hook<> {
 public:
  const Principal& principal() const { return principal_; }

 private:
  friend class Callers;
  Principal principal_;
  Bytes32 digest_{};  // SHA-256 of the token
  bool admitted_ = false;
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
  std::optional<Refused> admit(grpc::CallbackServerContext& context);

  /// Returns the allocator of the contexts that `admit` needs. It refers to this object.
  std::unique_ptr<grpc::ContextAllocator> context_allocator();

 private:
  friend class CallerContexts;
  void leave(CallerContext& context) noexcept {
    const std::lock_guard lock(mutex_);
    if (context.is_linked()) calls_.erase(calls_.iterator_to(context));
  }
  void take(const WatchedFiles::Contents& contents);
  void replace(TokenTable table);

  const Report report_;
  std::mutex mutex_;
  TokenTable table_;                             // guarded by mutex_
  boost::intrusive::list<CallerContext> calls_;  // guarded by mutex_; the admitted calls
  std::optional<WatchedFiles> watch_;
};

/// Returns the faults of a file of tokens, each with its line; empty for a valid file.
std::vector<std::string> faults_of_tokens(const std::string& file);

}  // namespace stiefel::server
