#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace stiefel::cli {

/// A file that appears under its name only when it is complete. It is written as PATH.part;
/// `commit` renames it, without which the destructor removes it. Devices and pipes are written
/// directly.
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

/// Removes the PATH.part of every Destination that is not complete. Call it, from any thread,
/// before the process ends without unwinding.
void remove_partial_files();

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// Opens a file for writing. Throws BadInput if that fails.
File open_for_writing(const std::string& path);
/// Throws std::runtime_error with the reason, such as a full disk.
void write(std::FILE* file, std::string_view bytes);
/// Throws std::runtime_error with the reason, such as a full disk.
void flush(std::FILE* file);
/// Writes the text to the destination and commits it; to stdout without one.
void write_whole(std::optional<Destination>& destination, std::string_view text);

}  // namespace stiefel::cli
