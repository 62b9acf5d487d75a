#pragma once

#include <stdexcept>
#include <string>

#include "server/sessions/store/store.h"

/// Rows, and what a store without a journal says.
namespace stiefel::test {

inline server::StoredSession session(const std::string& id, std::size_t bytes = 100) {
  std::string scene(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) scene[i] = static_cast<char>(i * 31 + id.size());
  return {server::Principal{}, id,    1'700'000'000'123'456'789, "0123456789abcdef",
          0xFEDCBA9876543210,  scene, "method\nmethod.order\n",  "body\n",
          std::nullopt};
}

inline void put(server::Store& store, const server::StoredSession& one) {
  store.transact([&] { store.put(one); });
}

/// What the constructor says, or "" if it opens.
inline std::string refusal(const server::StoreOptions& options) {
  try {
    const server::Store store(options);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace stiefel::test
