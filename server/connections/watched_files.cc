#include "server/connections/watched_files.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace stiefel::server {
namespace {

constexpr std::uintmax_t largest_file = 16 << 20;

}  // namespace

std::expected<std::string, std::string> read_text(const std::string& path) {
  std::error_code fault;
  const auto status = std::filesystem::status(path, fault);
  if (fault) return std::unexpected(fault.message());
  if (!is_regular_file(status)) return std::unexpected("it must be a regular file");
  if (std::filesystem::file_size(path, fault) > largest_file)
    return std::unexpected("it has more than 16 MiB");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) return std::unexpected(std::strerror(errno));
  return text;
}

WatchedFiles::WatchedFiles(std::vector<std::string> paths, const Log& log, const char* what,
                           Use use, std::chrono::milliseconds pause)
    : paths_(std::move(paths)),
      log_(log),
      what_(what),
      use_(std::move(use)),
      known_(read()),
      last_(known_) {
  use_(known_);
  thread_.emplace("watch-files", pause, [this](const auto&) { look(); });
}

WatchedFiles::Contents WatchedFiles::read() const {
  Contents contents;
  for (const std::string& path : paths_) contents.push_back(read_text(path));
  return contents;
}

void WatchedFiles::look() {
  Contents now = read();
  const bool calm = now == last_;
  last_ = std::move(now);
  if (!calm || last_ == known_) return;
  try {
    use_(last_);
    log_.line(Log::Level::info, "new " + what_);
  } catch (const std::runtime_error& fault) {
    log_.line(Log::Level::error, what_ + " at fault", {{"fault", fault.what()}});
  }
  known_ = last_;  // not after std::bad_alloc: the next look uses them
}

}  // namespace stiefel::server
