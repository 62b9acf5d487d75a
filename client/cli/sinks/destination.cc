#include "client/cli/sinks/destination.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <set>
#include <stdexcept>

#include "client/cli/exit_status.h"

namespace stiefel::cli {

namespace fs = std::filesystem;

namespace {

/// The incomplete files of this process. Never destroyed, because a signal may come while the
/// process ends.
struct Partial {
  std::mutex mutex;
  std::set<std::string> paths;
};

Partial& partial() {
  static auto& one = *new Partial;
  return one;
}

}  // namespace

Destination::Destination(const std::string& path) {
  std::error_code none;
  const fs::path target = fs::exists(path, none) ? fs::canonical(path, none) : fs::path(path);
  if (fs::is_directory(target, none)) throw BadInput("--output: " + path + " is a directory");
  const bool replaceable = !fs::exists(target, none) || fs::is_regular_file(target, none);
  path_ = target;
  working_ = replaceable ? path_ + ".part" : path_;
  if (working_ == path_) return;
  const std::lock_guard lock(partial().mutex);
  partial().paths.insert(working_);
}

Destination::~Destination() {
  if (committed_ || working_ == path_) return;
  const std::lock_guard lock(partial().mutex);
  partial().paths.erase(working_);
  std::error_code ignored;
  fs::remove(working_, ignored);
}

void Destination::commit() {
  if (working_ != path_) {
    const std::lock_guard lock(partial().mutex);
    fs::rename(working_, path_);
    partial().paths.erase(working_);
  }
  committed_ = true;
}

void remove_partial_files() {
  const std::lock_guard lock(partial().mutex);
  for (const std::string& path : partial().paths) {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
}

File open_for_writing(const std::string& path) {
  File file(std::fopen(path.c_str(), "wb"));
  if (!file) throw BadInput("--output: cannot write " + path + ": " + std::strerror(errno));
  return file;
}

void write(std::FILE* file, std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) {
    throw std::runtime_error(std::string("cannot write the samples: ") + std::strerror(errno));
  }
}

void flush(std::FILE* file) {
  if (std::fflush(file) != 0) {
    throw std::runtime_error(std::string("cannot write the samples: ") + std::strerror(errno));
  }
}

void write_whole(std::optional<Destination>& destination, std::string_view text) {
  if (!destination) {
    std::cout << text;
    return;
  }
  const File file = open_for_writing(destination->working_path());
  write(file.get(), text);
  flush(file.get());
  destination->commit();
}

}  // namespace stiefel::cli
