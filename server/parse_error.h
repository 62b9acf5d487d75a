#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace stiefel::server {

/// Returns the faults of the program's command line, one on each line, and where to read more.
/// Unknown words are reported as "unknown command runn; did you mean run?" or "unknown option
/// --evry; did you mean --every?". CLI11's message is used only if there are none, because a
/// missing argument may be a misspelt one.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace stiefel::server
