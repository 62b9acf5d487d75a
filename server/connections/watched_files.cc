#include "server/connections/watched_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "server/scheduling/process.h"

namespace stiefel::server {
namespace {

constexpr std::size_t largest_file = std::size_t{16} << 20;

std::unexpected<std::string> system_fault() {
  return std::unexpected<std::string>(std::strerror(errno));
}

}  // namespace

std::expected<std::string, std::string> read_text(const std::string& path) {
  // Without O_NONBLOCK, opening a pipe would wait for its writer.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) return system_fault();
  struct stat found;
  if (fstat(file.get(), &found) != 0) return system_fault();
  if (!S_ISREG(found.st_mode)) return std::unexpected("it must be a regular file");
  std::string text;
  char buffer[65536];
  while (true) {
    const ssize_t got = ::read(file.get(), buffer, sizeof buffer);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_fault();
    if (got == 0) return text;
    text.append(buffer, static_cast<std::size_t>(got));
    if (text.size() > largest_file) return std::unexpected("it has more than 16 MiB");
  }
}

WatchedFiles::Contents read_texts(const std::vector<std::string>& paths) {
  WatchedFiles::Contents contents;
  for (const std::string& path : paths) contents.push_back(read_text(path));
  return contents;
}

WatchedFiles::WatchedFiles(std::vector<std::string> paths, Contents known, Changed changed,
                           std::chrono::milliseconds pause)
    : paths_(std::move(paths)),
      changed_(std::move(changed)),
      known_(std::move(known)),
      last_(known_),
      thread_("watch-files", pause, [this](const auto&) { look(); }) {}

void WatchedFiles::look() {
  Contents now = read_texts(paths_);
  const bool calm = now == last_;
  last_ = std::move(now);
  if (!calm || last_ == known_) return;
  changed_(last_);
  known_ = last_;
}

}  // namespace stiefel::server
