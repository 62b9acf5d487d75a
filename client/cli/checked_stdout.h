#pragma once

#include <iostream>
#include <streambuf>

namespace stiefel::cli {

/// While an object of this class exists, a failed write to std::cout throws std::runtime_error with
/// the system's reason, such as "cannot write to stdout: No space left on device".
class CheckedStdout : std::streambuf {
 public:
  CheckedStdout();
  ~CheckedStdout() override;

  /// Writes what is buffered. Throws std::runtime_error if that fails.
  void flush();

 private:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;

  std::streambuf* before_;
};

}  // namespace stiefel::cli
