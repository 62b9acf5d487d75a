#include "client/cpp/uuid.h"

#include <random>

namespace stiefel::client {

std::string make_uuid() {
  std::random_device random;
  std::string uuid = "xxxxxxxx-xxxx-4xxx-yxxx-xxxxxxxxxxxx";
  for (char& c : uuid) {
    const unsigned digit = random() & 15u;
    if (c == 'x') c = "0123456789abcdef"[digit];
    if (c == 'y') c = "89ab"[digit & 3u];
  }
  return uuid;
}

}  // namespace stiefel::client
