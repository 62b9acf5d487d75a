#include <gnu/libc-version.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "stiefel/simulation.h"
#include "stiefel/version.h"

namespace stiefel {

const std::string& build_fingerprint() {
  static const std::string fingerprint = [] {
    std::string text = "stiefel " STIEFEL_VERSION ", gcc " __VERSION__ ", " STIEFEL_BUILD_FLAGS;
    text += ", glibc " + std::string(gnu_get_libc_version());
    // The C library's sin and cos differ in the last bit between processors with and without fused
    // multiply-add.
    text += __builtin_cpu_supports("fma") ? ", fma" : "";
    text += __builtin_cpu_supports("avx2") ? ", avx2" : "";
    return text;
  }();
  return fingerprint;
}

const std::string& machine() {
  static const std::string name = [] {
    std::ifstream cpus("/proc/cpuinfo");
    std::string model = "unknown CPU";
    for (std::string line; std::getline(cpus, line);)
      if (line.starts_with("model name") && line.find(": ") != std::string::npos) {
        model = line.substr(line.find(": ") + 2);
        break;
      }
    return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
  }();
  return name;
}

Eigen::MatrixXd Simulation::get(std::string_view name) const {
  const auto field = std::ranges::find(fields_, name, &Field::name);
  if (field == fields_.end())
    throw std::invalid_argument("the scene has no field " + std::string(name));
  const int rows = field->rows * std::max(1, field->members);
  RowMatrix value(rows, field->size() / rows);
  write(static_cast<std::size_t>(field - fields_.begin()),
        {value.data(), static_cast<std::size_t>(field->size())});
  return value;
}

}  // namespace stiefel
