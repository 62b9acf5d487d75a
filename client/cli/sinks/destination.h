#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace stiefel::cli {

/// A file that appears under its name only when it is complete: written beside it as PATH.part,
/// removed if `commit` is not called. Devices and pipes are written directly.
class Destination {
 public:
  explicit Destination(const std::string& path);
  ~Destination();
  Destination(const Destination&) = delete;
  Destination& operator=(const Destination&) = delete;

  const std::string& working_path() const { return working_; }
  void commit();

 private:
  std::string path_;
  std::string working_;
  bool committed_ = false;
};

/// Removes the PATH.part of every Destination that is not complete, for a process that ends without
/// unwinding. From any thread.
void remove_partial_files();

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// Throws BadInput if it cannot be opened.
File open_for_writing(const std::string& path);
/// Both throw std::runtime_error with the reason, such as a full disk.
void write(std::FILE* file, std::string_view bytes);
void flush(std::FILE* file);

}  // namespace stiefel::cli
