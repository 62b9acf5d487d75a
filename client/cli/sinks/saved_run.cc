#include "client/cli/sinks/saved_run.h"

#include <minizip/unzip.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

#include "client/cli/exit_status.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/sinks/description.h"

namespace stiefel::cli {
namespace {

using nlohmann::ordered_json;

BadInput not_saved(const std::string& path, const std::string& why) {
  return BadInput(path + ": is not a file that stiefel run --output wrote: " + why);
}

std::string whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BadInput(path + " cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Returns the entry of an archive at which it stands, without the header of the .npy format.
std::string current_array(unzFile archive) {
  std::string bytes;
  char block[1 << 16];
  if (unzOpenCurrentFile(archive) != UNZ_OK) return bytes;
  for (int size; (size = unzReadCurrentFile(archive, block, sizeof block)) > 0;)
    bytes.append(block, static_cast<std::size_t>(size));
  unzCloseCurrentFile(archive);
  if (bytes.size() < 10 || bytes.compare(0, 8, std::string("\x93NUMPY\x01\x00", 8)) != 0) return "";
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  return bytes.substr(std::min<std::size_t>(bytes.size(), 10u + byte(8) + 256u * byte(9)));
}

SavedRun from_npz(const std::string& path) {
  const std::unique_ptr<void, int (*)(void*)> archive(
      unzOpen64(path.c_str()), [](void* one) { return one ? unzClose(one) : 0; });
  if (!archive) throw not_saved(path, "no archive");
  SavedRun found;
  for (int at = unzGoToFirstFile(archive.get()); at == UNZ_OK;
       at = unzGoToNextFile(archive.get())) {
    char name[256] = {};
    unz_file_info64 info;
    unzGetCurrentFileInfo64(archive.get(), &info, name, sizeof name - 1, nullptr, 0, nullptr, 0);
    const std::string array = current_array(archive.get());
    if (std::string_view(name) == "stiefel.npy")
      found.description = ordered_json::parse(array, nullptr, false);
    else
      found.samples.append(name).append("\n").append(array);
  }
  return found;
}

SavedRun from_csv(const std::string& path) {
  SavedRun found{ordered_json::object(), ""};
  std::istringstream lines(whole(path));
  bool has_utc = false;  // the last column, of the Python client alone
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("step")) has_utc = line.ends_with(",utc");
    if (!line.starts_with("#"))
      found.samples += line.substr(0, has_utc ? line.rfind(',') : line.size()) + '\n';
    else if (line.starts_with("# {"))
      if (const auto part = ordered_json::parse(line.substr(2), nullptr, false); part.is_object())
        found.description.update(part);
  }
  return found;
}

/// Writes the fields of a sample as nested lists where an earlier version wrote objects with rows
/// and cols.
void in_lists(ordered_json& sample) {
  if (!sample.is_object() || !sample.contains("fields")) return;
  for (auto& [name, field] : sample["fields"].items()) {
    if (!field.is_object() || !field.contains("rows")) continue;
    std::vector<std::size_t> lengths;
    if (field.contains("members")) lengths.push_back(field["members"].get<std::size_t>());
    if (kind_of(name).axes == 2) lengths.push_back(field["rows"].get<std::size_t>());
    if (kind_of(name).axes > 0) lengths.push_back(field.at("cols").get<std::size_t>());
    field = nested_matrix(field, lengths);
  }
}

SavedRun from_json(const std::string& path) {
  SavedRun found{ordered_json::parse(whole(path), nullptr, false), ""};
  if (!found.description.is_object()) return found;
  try {
    for (auto& sample : found.description["samples"]) in_lists(sample);
  } catch (const nlohmann::json::exception& error) {
    throw not_saved(path, error.what());
  }
  found.samples = found.description.value("samples", ordered_json::array()).dump();
  found.description.erase("samples");
  return found;
}

}  // namespace

SavedRun read_saved_run(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension != ".npz" && extension != ".csv" && extension != ".json")
    throw BadInput(path + ": must end in .json, .csv or .npz");
  if (!std::filesystem::is_regular_file(path)) throw BadInput(path + " cannot be read");
  SavedRun found = extension == ".npz"   ? from_npz(path)
                   : extension == ".csv" ? from_csv(path)
                                         : from_json(path);
  if (!found.description.is_object() || found.description.value("format", "") != trajectory_format)
    throw not_saved(path, "no description");
  for (const char* part : {"scene", "run", "numerics_id"})
    if (!found.description.contains(part)) throw not_saved(path, std::string("no ") + part);
  return found;
}

}  // namespace stiefel::cli
