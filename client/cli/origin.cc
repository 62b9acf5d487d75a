#include "client/cli/origin.h"

#include <charconv>

namespace stiefel::cli {

std::string Origin::place(const std::string& field) const {
  const std::string name = field.substr(0, field.find_first_of(".["));
  if (const auto option = options.find(name); option != options.end())
    return option->second +
           (name == "times" ? index_of_time(field.substr(name.size())) : field.substr(name.size()));
  if (whole_request) {
    const std::string only = "pairs[0].";
    return file + ": " +
           (single_pair && field.starts_with(only) ? field.substr(only.size()) : field);
  }
  if (field == "scene") return file;
  if (name != "scene") return field;
  const std::string path = field.substr(name.size() + 1);
  const auto given = renamed.find(path);
  return file + ": " + (given == renamed.end() ? path : given->second);
}

std::string Origin::index_of_time(const std::string& index) const {
  std::size_t k = times.size();
  if (index.starts_with("[")) std::from_chars(index.data() + 1, index.data() + index.size(), k);
  return k < times.size() ? std::string("[").append(std::to_string(times[k])) + "]" : index;
}

}  // namespace stiefel::cli
