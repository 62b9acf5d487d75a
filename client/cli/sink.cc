#include "client/cli/sink.h"

#include <charconv>
#include <filesystem>
#include <string_view>

#include "client/cli/exit_status.h"

namespace stiefel::cli {

std::unique_ptr<Sink> make_sink(const std::string& path) {
  if (path.empty()) return make_json_sink(path);
  const std::string extension = std::filesystem::path(path).extension();
  if (extension == ".json") return make_json_sink(path);
  if (extension == ".csv") return make_csv_sink(path);
  if (extension == ".npz") return make_npz_sink(path);
  throw BadInput("--output: " + path + " must end in .json, .csv or .npz");
}

void append_number(std::string& text, double number) {
  char digits[32];
  const char* end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  const std::string_view written(digits, end);
  text += written;
  if (written.find_first_of(".en") == std::string_view::npos) text += ".0";
}

}  // namespace stiefel::cli
