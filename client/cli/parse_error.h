#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace stiefel::cli {

/// The faults of the command line, one a line: "unknown command runn; did you mean run?",
/// "unknown option --evry; did you mean --every?", else what CLI11 says; and where to read more.
/// Unknown words come first: a missing argument may be a misspelt one.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace stiefel::cli
