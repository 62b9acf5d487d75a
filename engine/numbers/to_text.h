#pragma once

#include <charconv>
#include <span>
#include <string>

namespace stiefel {

/// Writes a number as every text of the project has it: the shortest decimal that reads back to the
/// same bits, "0.1", "1e-09", "inf", "nan".
inline std::string to_text(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

/// Rounds a number to `digits` significant digits: to_text(2 / 3., 2) is "0.67".
inline std::string to_text(double x, int digits,
                           std::chars_format format = std::chars_format::general) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, x, format, digits).ptr};
}

/// Writes a number with `digits` ≤ 50 significant digits and always an exponent: "2.1e-09".
inline std::string scientific_text(double x, int digits) {
  return to_text(x, digits - 1, std::chars_format::scientific);
}

/// Writes a number with two significant digits: "2.1e-09".
inline std::string short_text(double x) { return scientific_text(x, 2); }

/// Writes a list, cut off after 8 numbers: "[1, 2.5, 0.1]".
inline std::string to_text(std::span<const double> v) {
  std::string out = "[";
  for (std::size_t k = 0; k < v.size() && k < 8; ++k) out += (k > 0 ? ", " : "") + to_text(v[k]);
  return out + (v.size() > 8 ? ", …]" : "]");
}

}  // namespace stiefel
