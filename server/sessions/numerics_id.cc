#include "server/sessions/numerics_id.h"

#include <array>
#include <cstdio>

#include "server/sessions/identity.h"
#include "stiefel/version.h"

namespace stiefel::server {

const std::string& numerics_id() {
  static const std::string id = [] {
    std::array<char, 17> digits;
    std::snprintf(digits.data(), digits.size(), "%016llx",
                  static_cast<unsigned long long>(hash(build_fingerprint())));
    return std::string(digits.data());
  }();
  return id;
}

}  // namespace stiefel::server
