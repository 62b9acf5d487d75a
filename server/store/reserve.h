#pragma once

#include <string>
#include <utility>

namespace stiefel::server {

/// Space on the disk that is held back for deletions: a file of `bytes`, which is removed when the
/// disk is full. It does what it can: a reserve that cannot be had is no error.
class Reserve {
 public:
  static constexpr long bytes = 2L << 20;

  explicit Reserve(std::string file) : file_(std::move(file)) {}

  /// Makes the file, unless the disk is too full for it.
  void hold() noexcept;
  void release() noexcept;

 private:
  std::string file_;
};

}  // namespace stiefel::server
