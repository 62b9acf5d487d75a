#include "client/cli/command.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <map>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <string_view>

#include "client/cli/interrupt.h"
#include "stiefel/client/error.h"

namespace stiefel::cli {
namespace {

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

/// Throws if the last write failed. Must follow the write directly, because it reads errno.
void check(bool written) {
  if (!written) {
    throw std::runtime_error("cannot write to stdout: " + std::string(std::strerror(errno)));
  }
}

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

void say(const std::string& fault) { std::cerr << "stiefel: error: " + fault + '\n'; }

/// Returns the option that may help; empty if none does.
std::string remedy(const client::Error& error) {
  const std::string what = error.what();
  if (what.ends_with("as a server with TLS does to a client without"))
    return ": give --tls-ca or STIEFEL_TLS_CA";
  if (error.reason() == "TOKEN_MISSING") return "; here: --token-file or STIEFEL_TOKEN";
  return "";
}

/// Prints an error to stderr, one line for each fault, and returns the exit status.
ExitStatus explain(const client::Error& error, const Origin& origin) {
  for (const auto& violation : error.violations())
    say(origin.place(violation.field) + ": " + violation.description);
  if (error.violations().empty()) say(error.what() + remedy(error));
  if (error.code() == grpc::StatusCode::INVALID_ARGUMENT || !error.violations().empty()) {
    return bad_input;
  }
  const bool unreachable = error.code() == grpc::StatusCode::UNAVAILABLE ||
                           error.code() == grpc::StatusCode::DEADLINE_EXCEEDED;
  return unreachable ? no_server : failed;
}

struct Registered {
  const char* description;
  Subcommand::Add add;
};

/// By name. Static objects in other files fill it.
std::map<std::string_view, Registered>& subcommands() {
  static std::map<std::string_view, Registered> all;
  return all;
}

}  // namespace

Subcommand::Subcommand(const char* name, const char* description, Add add) {
  subcommands()[name] = {description, add};
}

void Subcommand::add_all(CLI::App& program, Command& chosen) {
  for (const auto& [name, one] : subcommands())
    one.add(program.add_subcommand(std::string(name), one.description), chosen);
}

ExitStatus perform(Command& command) {
  catch_interrupts();
  try {
    CheckedStdout out;
    const ExitStatus status = command.run(command.origin);
    out.flush();
    return status;
  } catch (const Interrupted& how_far) {
    end_interrupted(how_far.what());
  } catch (const BadInput& error) {
    say(error.what());
    return bad_input;
  } catch (const client::Error& error) {
    if (interrupted()) end_interrupted("");
    return explain(error, command.origin);
  } catch (const std::exception& error) {
    if (interrupted()) end_interrupted("");
    say(error.what());
    return failed;
  }
}

}  // namespace stiefel::cli
