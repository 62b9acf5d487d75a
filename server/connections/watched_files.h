#pragma once

#include <chrono>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/scheduling/process.h"

namespace stiefel::server {

/// Returns the text of a regular file of at most 16 MiB, or why it cannot be read.
std::expected<std::string, std::string> read_text(const std::string& path);

/// Reads files periodically on a thread of its own. Reports new contents once two readings in a row
/// agree, one to two pauses after the writing, so that a half-written file is never used.
class WatchedFiles {
 public:
  using Contents =
      std::vector<std::expected<std::string, std::string>>;  // in the order of the paths
  using Changed = std::function<void(const Contents&)>;
  static constexpr auto default_pause = std::chrono::milliseconds(500);

  /// `known` is what the caller has read already. `changed` is called on the thread and may throw.
  WatchedFiles(std::vector<std::string> paths, Contents known, Changed changed,
               std::chrono::milliseconds pause = default_pause);

 private:
  void look();

  const std::vector<std::string> paths_;
  const Changed changed_;
  Contents known_, last_;
  Periodic thread_;
};

/// Returns the current contents of the files.
WatchedFiles::Contents read_texts(const std::vector<std::string>& paths);

}  // namespace stiefel::server
