#pragma once

#include <boost/intrusive/list.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/access/caller_context.h"
#include "server/access/tokens.h"
#include "server/access/watched_files.h"

namespace stiefel::server {

/// Why a call is not let in.
enum class Refused { token_missing, token_unknown };

/// Who may call: the file of tokens, read again when it changes, and the calls that run with them.
/// When a token is withdrawn its calls end with UNAUTHENTICATED, and no new one begins.
/// Thread-safe.
class Callers {
 public:
  /// A change of the file: how many tokens it has, and the lines that are none, or why it cannot be
  /// read.
  struct Change {
    std::size_t tokens;
    std::vector<std::string> faults;
  };
  using Report = std::function<void(const Change&)>;

  /// Throws std::runtime_error where the file cannot be read or has a line that is none. Later such
  /// a line lets nobody in, and a file that cannot be read lets nobody in at all: what is doubtful
  /// closes.
  Callers(const std::string& file, Report report);
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  /// Lets a call in by its metadata `authorization`, and no other; once for each call.
  std::optional<Refused> admit(grpc::CallbackServerContext& context);

  /// Makes the contexts, which admit needs. It refers to this object.
  std::unique_ptr<grpc::ContextAllocator> context_allocator();

 private:
  friend class CallerContexts;
  void leave(CallerContext& context) noexcept;
  void take(const WatchedFiles::Contents& contents);
  void replace(TokenTable table);

  const Report report_;
  std::mutex mutex_;
  TokenTable table_;                             // guarded by mutex_
  boost::intrusive::list<CallerContext> calls_;  // guarded by mutex_; those that were let in
  std::optional<WatchedFiles> watch_;
};

/// The faults of a file of tokens, each with its line; empty for a sound one.
std::vector<std::string> faults_of_tokens(const std::string& file);

}  // namespace stiefel::server
