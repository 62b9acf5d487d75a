#include "server/store/file_watch.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace stiefel::server {

FileWatch::FileWatch(std::vector<std::string> names) {
  for (std::string& name : names) {
    struct stat now {};
    if (stat(name.c_str(), &now) != 0) throw std::runtime_error(name + ": " + std::strerror(errno));
    files_.push_back({std::move(name), now.st_dev, now.st_ino});
  }
  if (const auto wrong = fault()) throw std::runtime_error(*wrong);
}

std::optional<std::string> FileWatch::fault() const {
  for (const File& file : files_) {
    struct stat now {};
    if (stat(file.name.c_str(), &now) != 0)
      return file.name + " was removed or cannot be reached: " + std::strerror(errno) +
             ": restart the server";
    if (now.st_dev != file.device || now.st_ino != file.inode)
      return file.name + " was replaced by another file: restart the server";
    if (now.st_nlink != 1)
      return file.name + " has " + std::to_string(now.st_nlink) +
             " names (hard links), must have 1: remove the others";
  }
  return std::nullopt;
}

}  // namespace stiefel::server
