#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace stiefel::server {

/// Watches the names of files that SQLite has open: what is written into a file without a name is
/// lost when the process ends, and a file with a second name has a second log.
class FileWatch {
 public:
  /// The files that have these names now. Throws std::runtime_error if one is absent.
  explicit FileWatch(std::vector<std::string> names);

  /// Returns what is wrong: the name is gone or belongs to another file, or the file has further
  /// names.
  std::optional<std::string> fault() const;

 private:
  struct File {
    std::string name;
    dev_t device;
    ino_t inode;
  };
  std::vector<File> files_;
};

}  // namespace stiefel::server
