#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace stiefel::cli {

/// What is wrong with the command line, a line a fault: "unknown command runn; did you mean run?",
/// "unknown option --evry; did you mean --every?", else what CLI11 says; and where to read more.
/// Words that nobody knows come first, because what is missing besides may be what they stand for.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace stiefel::cli
