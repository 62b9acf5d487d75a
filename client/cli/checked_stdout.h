#pragma once

#include <iostream>
#include <streambuf>

namespace stiefel::cli {

/// While one exists, a write to std::cout that fails throws std::runtime_error with the reason
/// that the system gave, for example "cannot write to stdout: No space left on device".
class CheckedStdout : std::streambuf {
 public:
  CheckedStdout();
  ~CheckedStdout() override;

  /// Writes what is buffered. Throws as a write does.
  void flush();

 private:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;

  std::streambuf* before_;
};

}  // namespace stiefel::cli
