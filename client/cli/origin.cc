#include "client/cli/origin.h"

namespace stiefel::cli {

std::string Origin::place(const std::string& field) const {
  const std::string name = field.substr(0, field.find_first_of(".["));
  if (const auto option = options.find(name); option != options.end())
    return option->second + field.substr(name.size());
  if (whole_request) {
    const std::string only = "pairs[0].";
    return file + ": " +
           (single_pair && field.starts_with(only) ? field.substr(only.size()) : field);
  }
  if (field == "scene") return file;
  return name == "scene" ? file + ": " + field.substr(name.size() + 1) : field;
}

}  // namespace stiefel::cli
