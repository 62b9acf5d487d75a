#include <gnu/libc-version.h>

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <thread>

#include "engine/simulation/simulation.h"

namespace stiefel {

const std::string& build_fingerprint() {
  static const std::string fingerprint = [] {
    std::string text = "stiefel " STIEFEL_VERSION ", gcc " __VERSION__ ", " STIEFEL_BUILD_FLAGS;
    text += ", glibc " + std::string(gnu_get_libc_version());
    // The C library's sin and cos differ in the last bit with and without fused multiply-add.
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
  const int rows = field->rows * std::max(1, field->members);
  RowMatrix value(rows, field->size() / rows);
  write(static_cast<std::size_t>(field - fields_.begin()),
        {value.data(), static_cast<std::size_t>(field->size())});
  return value;
}

std::string to_sentence(const Ending& ending) {
  if (ending.member) {
    Ending of_one = ending;
    of_one.member.reset();
    return "member " + std::to_string(*ending.member) + ": " + to_sentence(of_one);
  }
  switch (ending.outcome) {
    case Outcome::reached:
      return "";
    case Outcome::left_domain: {
      std::ostringstream sentence;
      sentence << "the step has no solution on the principal branch; the largest |h| that has one "
                  "here is "
               << std::setprecision(4) << ending.largest_step.value_or(0);
      return sentence.str();
    }
    case Outcome::solver_stalled:
      return "the solver of the implicit step did not converge";
    case Outcome::not_finite:
      return "the next state is not finite";
    case Outcome::cancelled:
      return "the run was cancelled";
  }
  return "";
}

}  // namespace stiefel
