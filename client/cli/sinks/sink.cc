#include "client/cli/sinks/sink.h"

#include <filesystem>

#include "client/cli/exit_status.h"
#include "engine/numbers/to_text.h"

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
  const std::string written = stiefel::to_text(number);
  text += written;
  if (written.find_first_of(".en") == std::string::npos) text += ".0";
}

}  // namespace stiefel::cli
