#pragma once

#include <functional>
#include <string>
#include <thread>

namespace stiefel::cli {

/// Where a status line goes: on a terminal it is rewritten in place and may have a bar; in a log it
/// is a line of its own.
struct Room {
  int columns = 79;
  bool terminal = true;
};

/// Tells on stderr what a command waits for: on a terminal from the first second on, four times a
/// second; elsewhere a line every ten seconds.
class StatusLine {
 public:
  /// The line, at most `columns` wide, called from a thread of its own four times a second on a
  /// terminal and once a second elsewhere, whether it is shown or not.
  using Text = std::function<std::string(const Room&)>;

  explicit StatusLine(Text text);
  /// Clears what it wrote on a terminal.
  ~StatusLine() = default;
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

 private:
  Text text_;
  std::jthread writer_;
};

/// "1:05", "2:00:09", "12 days", "3e+04 years".
std::string duration(double seconds);

/// "[====    ]  50 %  WORDS", or "50 %, WORDS" where there is no bar; the bar takes what is left of
/// the columns, at most 30, and is left out where that is too little.
std::string with_bar(double fraction, const std::string& words, const Room& room);

/// "variational 4, pl...": at most `columns` characters of UTF-8 text.
std::string cut(const std::string& text, int columns);

}  // namespace stiefel::cli
