#pragma once

#include <chrono>
#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/connections/log.h"
#include "server/scheduling/process.h"

namespace stiefel::server {

/// Returns the text of a regular file of at most 16 MiB, or why it cannot be read.
std::expected<std::string, std::string> read_text(const std::string& path);

/// Files that are used together and read again periodically on a thread of its own. New contents
/// are used once two readings in a row agree, one to two pauses after the writing, so that a
/// half-written file is never used.
class WatchedFiles {
 public:
  using Contents =
      std::vector<std::expected<std::string, std::string>>;  // in the order of the paths
  /// Takes over what the files hold. Throws std::runtime_error with what is wrong with it.
  using Use = std::function<void(const Contents&)>;
  static constexpr auto default_pause = std::chrono::milliseconds(500);

  /// Reads the files and lets `use` take them over; what it throws passes. Later calls of `use` are
  /// on the thread: the log then has the line "new WHAT" or "WHAT at fault".
  WatchedFiles(std::vector<std::string> paths, const Log& log, const char* what, Use use,
               std::chrono::milliseconds pause = default_pause);

 private:
  Contents read() const;
  void look();

  const std::vector<std::string> paths_;
  const Log& log_;
  const std::string what_;
  const Use use_;
  Contents known_, last_;
  std::optional<Periodic> thread_;
};

}  // namespace stiefel::server
