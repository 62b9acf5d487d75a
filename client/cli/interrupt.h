#pragma once

#include <stdexcept>
#include <stop_token>
#include <string>

namespace stiefel::cli {

/// Makes SIGINT, SIGTERM and SIGHUP cancel the command, except those that the caller of the process
/// ignores (as nohup does). The first signal requests the stop of `interruption()`; the command
/// then has three seconds to throw `Interrupted` or to end. After that, or at a second signal, the
/// process ends at once. Call it once, before any thread is started, because threads inherit the
/// blocked signals.
void catch_interrupts();

/// The token whose stop cancels every call of the command.
std::stop_token interruption();

/// Returns whether a signal has come.
bool interrupted();

/// Thrown by an interrupted command. The message says how far the command got, as in "at step 1200
/// of 10000; nothing was written".
struct Interrupted : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Prints to stderr that the command was interrupted and how far it got, removes incomplete files,
/// and ends the process by the signal that came, so that a shell sees the status 128 + signal.
[[noreturn]] void end_interrupted(const std::string& how_far);

}  // namespace stiefel::cli
