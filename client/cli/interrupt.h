#pragma once

#include <stdexcept>
#include <stop_token>
#include <string>

namespace stiefel::cli {

/// SIGINT, SIGTERM and SIGHUP, as far as the caller does not have them ignored (as nohup does),
/// cancel what runs: the first one requests the stop of `interruption()`. After it the command has
/// three seconds to throw `Interrupted` or to end; then, or at a second signal, the process ends
/// without it. Once, before any thread is started: threads inherit the blocked signals.
void catch_interrupts();

/// Cancels every call of the command.
std::stop_token interruption();

/// True after a signal.
bool interrupted();

/// How far an interrupted command got, as in "at step 1200 of 10000; nothing was written".
struct Interrupted : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Says "interrupted" and how far the command got on stderr, removes files that are not complete,
/// and ends the process by the signal that came, so that a shell sees the status 128 + signal.
[[noreturn]] void end_interrupted(const std::string& how_far);

}  // namespace stiefel::cli
