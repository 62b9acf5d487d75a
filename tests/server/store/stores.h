#pragma once

#include <signal.h>
#include <sys/resource.h>

#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "server/sessions/store/store.h"
#include "server/sessions/store/store_writer.h"

/// Rows, and what a store says of them.
namespace stiefel::test {

inline server::StoredSession row(const std::string& id, std::size_t bytes = 100) {
  std::string scene(bytes, '\0');
  for (std::size_t i = 0; i < bytes; ++i) scene[i] = static_cast<char>(i * 31 + id.size());
  return {{},
          id,
          1'700'000'000'123'456'789,
          "0123456789abcdef",
          std::string("\0\1\xFF", 3),
          scene,
          std::string("a\0b", 3)};
}

inline void put(server::Store& store, const server::StoredSession& one) {
  store.transact([&] { store.put(one); });
}

/// What a store has, by principal and id.
inline std::map<std::string, server::Store::Row> rows(server::Store& store) {
  std::map<std::string, server::Store::Row> all;
  server::Store::Reader reader(store);
  while (auto one = reader.next())
    all.emplace(one->session.principal.name + "/" + one->session.id, *std::move(one));
  return all;
}

/// What the constructor of a store says, or "" if it opens.
inline std::string refusal(const std::string& file) {
  try {
    const server::Store store(file);
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

/// While it lives, files of this process may have `bytes` bytes, as with `ulimit -f`: the disk is
/// full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
    handler_ = signal(SIGXFSZ, SIG_IGN);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  sighandler_t handler_;
};

}  // namespace stiefel::test
