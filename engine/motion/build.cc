#include <gnu/libc-version.h>

#include <Eigen/Core>
#include <boost/version.hpp>
#include <fstream>
#include <thread>

#include "engine/motion/build_flags.h"
#include "engine/motion/sources_digest.h"
#include "stiefel/version.h"

#define STIEFEL_TEXT_OF(number) #number
#define STIEFEL_TEXT(macro) STIEFEL_TEXT_OF(macro)
#define STIEFEL_EIGEN               \
  STIEFEL_TEXT(EIGEN_WORLD_VERSION) \
  "." STIEFEL_TEXT(EIGEN_MAJOR_VERSION) "." STIEFEL_TEXT(EIGEN_MINOR_VERSION)

namespace stiefel {

const std::string& build_fingerprint() {
  static const std::string fingerprint = [] {
    std::string text = "sources " STIEFEL_SOURCES_DIGEST;
    text += ", Eigen " STIEFEL_EIGEN ", Boost " BOOST_LIB_VERSION;
    text += ", gcc " __VERSION__ ", " STIEFEL_BUILD_FLAGS;
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

}  // namespace stiefel
