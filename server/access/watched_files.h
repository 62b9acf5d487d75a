#pragma once

#include <chrono>
#include <condition_variable>
#include <expected>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace stiefel::server {

/// The text of a regular file of at most 16 MiB, or why there is none.
std::expected<std::string, std::string> read_text(const std::string& path);

/// Reads files again and again in a thread of its own. New contents count when two looks in a row
/// agree, so that a file that is being written is never taken half: what was written is heard of
/// after one to two pauses.
class WatchedFiles {
 public:
  using Contents =
      std::vector<std::expected<std::string, std::string>>;  // in the order of the paths
  using Changed = std::function<void(const Contents&)>;
  static constexpr auto default_pause = std::chrono::milliseconds(500);

  /// `known`: the contents that the caller has already. `changed` is called by the thread, and may
  /// throw.
  WatchedFiles(std::vector<std::string> paths, Contents known, Changed changed,
               std::chrono::milliseconds pause = default_pause);

 private:
  void run(const std::stop_token& stop);
  void look();

  const std::vector<std::string> paths_;
  const Changed changed_;
  const std::chrono::milliseconds pause_;
  Contents known_, last_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

/// What the paths hold now.
WatchedFiles::Contents read_texts(const std::vector<std::string>& paths);

}  // namespace stiefel::server
