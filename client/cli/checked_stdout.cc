#include "client/cli/checked_stdout.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

namespace stiefel::cli {

namespace {

/// Throws if the last write failed. Must follow the write directly, because it reads errno.
void check(bool written) {
  if (!written) {
    throw std::runtime_error("cannot write to stdout: " + std::string(std::strerror(errno)));
  }
}

}  // namespace

CheckedStdout::CheckedStdout() : before_(std::cout.rdbuf(this)) {
  std::cout.exceptions(std::ios::badbit);
}

CheckedStdout::~CheckedStdout() {
  std::cout.exceptions(std::ios::goodbit);
  std::cout.rdbuf(before_);
}

void CheckedStdout::flush() { std::cout.flush(); }

CheckedStdout::int_type CheckedStdout::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof()))
    return traits_type::not_eof(character);
  check(std::fputc(character, stdout) != EOF);
  return character;
}

std::streamsize CheckedStdout::xsputn(const char* text, std::streamsize count) {
  check(std::fwrite(text, 1, static_cast<std::size_t>(count), stdout) ==
        static_cast<std::size_t>(count));
  return count;
}

int CheckedStdout::sync() {
  check(std::fflush(stdout) == 0);
  return 0;
}

}  // namespace stiefel::cli
