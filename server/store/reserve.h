#pragma once

#include <string>
#include <utility>

namespace stiefel::server {

/// Space on the disk held back for deletions: a file of `bytes` bytes, which is removed when the
/// disk is full. A reserve that cannot be held is not an error.
class Reserve {
 public:
  static constexpr long bytes = 2L << 20;

  explicit Reserve(std::string file) : file_(std::move(file)) {}

  /// Creates the file, unless the disk is too full for it.
  void hold() noexcept;
  void release() noexcept;

 private:
  std::string file_;
};

}  // namespace stiefel::server
