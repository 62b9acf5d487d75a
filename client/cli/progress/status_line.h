#pragma once

#include <functional>
#include <string>
#include <thread>

namespace stiefel::cli {

/// The space for a status line. On a terminal the line is rewritten in place and may have a bar; in
/// a log it is written anew each time.
struct Room {
  int columns = 79;
  bool terminal = true;
};

/// Shows on stderr what a command waits for: on a terminal four times a second, beginning after one
/// second; elsewhere a line every ten seconds.
class StatusLine {
 public:
  /// Returns the line, at most `columns` wide. It is called from another thread, four times a
  /// second on a terminal and once a second elsewhere, whether the line is shown or not.
  using Text = std::function<std::string(const Room&)>;

  explicit StatusLine(Text text);
  /// Clears the line on a terminal.
  ~StatusLine() = default;
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

 private:
  Text text_;
  std::jthread writer_;
};

/// Shows the status line "WHAT, 0:12" with the time since it was made, for a call that does not
/// tell how far it is.
class ElapsedLine {
 public:
  explicit ElapsedLine(std::string what);

 private:
  StatusLine line_;
};

/// Returns a duration for people: "1:05", "2:00:09", "12 days", "3e+04 years".
std::string duration(double seconds);

/// Returns "[====    ]  50 %  WORDS", or "50 %, WORDS" where there is no bar. The bar takes the
/// columns that are left, at most 30, and is left out if these are too few.
std::string with_bar(double fraction, const std::string& words, const Room& room);

/// Returns at most `columns` characters of UTF-8 text: "variational 4, pl...".
std::string cut(const std::string& text, int columns);

}  // namespace stiefel::cli
