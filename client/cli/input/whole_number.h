#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace stiefel::cli {

/// Returns a transformation of an option's text that takes every form of a whole number, such as
/// 1e3 and 30.0. It refuses other numbers with `hint`, which says what to use instead.
CLI::Validator whole_number(const std::string& hint = "");

}  // namespace stiefel::cli
