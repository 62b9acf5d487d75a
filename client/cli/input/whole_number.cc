#include "client/cli/input/whole_number.h"

#include <charconv>
#include <cmath>
#include <cstdint>

namespace stiefel::cli {
namespace {

/// Reads the whole text as a number.
template <class Number>
bool read(const std::string& text, Number& number) {
  const std::size_t plus = text.starts_with('+') ? 1 : 0;  // from_chars takes no +
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + plus, end, number);
  return error == std::errc() && rest == end;
}

}  // namespace

CLI::Validator whole_number(const std::string& hint) {
  const auto check = [hint](std::string& text) -> std::string {
    std::int64_t whole = 0;
    double number = 0;
    if (read(text, whole)) return "";
    if (!read(text, number) || number != std::floor(number) || std::abs(number) > 0x1p53)
      return text + ": must be a whole number" + hint;
    text = std::to_string(static_cast<std::int64_t>(number));
    return "";
  };
  return CLI::Validator(check, "", "");
}

}  // namespace stiefel::cli
