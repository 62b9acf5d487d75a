#include "server/transport/unix_listener.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "server/address.h"

namespace stiefel::server {
namespace {

constexpr mode_t owner_only = 0600;

SocketAddress address_of(const std::string& path) {
  SocketAddress address;
  auto& name = reinterpret_cast<sockaddr_un&>(address.storage);
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.c_str(), path.size() + 1);
  address.length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + 1);
  return address;
}

Descriptor new_socket() {
  return Descriptor(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

std::filesystem::path folder_of(const std::string& path) {
  return std::filesystem::absolute(path).parent_path();
}

constexpr const char* other_file = "the path is a file and no socket";

/// Locks the folder of a socket, so that servers that start together look at the path and bind it
/// one after another. Waits at most a second, so that nobody who may read the folder can block a
/// start.
Descriptor locked_folder(const std::string& path) {
  Descriptor lock(open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  for (int attempt = 0; lock && attempt < 100; ++attempt) {
    if (flock(lock.get(), LOCK_EX | LOCK_NB) == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return lock;
}

/// Removes the socket of a server that has ended; returns why the path cannot be bound, empty if it
/// can.
std::string make_free(const std::string& path, const SocketAddress& address) {
  struct stat found;
  if (lstat(path.c_str(), &found) != 0) return errno == ENOENT ? "" : std::strerror(errno);
  if (!S_ISSOCK(found.st_mode)) return other_file;
  const Descriptor probe = new_socket();
  if (!probe) return std::strerror(errno);
  if (connect(probe.get(), address.get(), address.length) == 0 || errno == EAGAIN)
    return "another server listens there";
  if (errno != ECONNREFUSED && errno != ENOENT) return std::strerror(errno);
  return unlink(path.c_str()) == 0 || errno == ENOENT ? "" : std::strerror(errno);
}

}  // namespace

SocketFile::SocketFile(std::string path) : path_(std::move(path)) {
  if (lstat(path_.c_str(), &made_) != 0) path_.clear();
}

SocketFile::SocketFile(SocketFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), made_(other.made_) {}

SocketFile::~SocketFile() {
  struct stat now;
  if (path_.empty() || lstat(path_.c_str(), &now) != 0) return;
  if (now.st_dev == made_.st_dev && now.st_ino == made_.st_ino) unlink(path_.c_str());
}

Listener listen_on_unix(const std::string& address) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error("cannot listen on " + address + ": " + why);
  };
  const std::string path(unix_path(address));
  const SocketAddress at = address_of(path);
  const Descriptor lock = locked_folder(path);
  if (const std::string fault = make_free(path, at); !fault.empty()) refuse(fault);
  Descriptor socket = new_socket();
  // On Linux the file gets the mode that the socket has when it is bound.
  if (!socket || fchmod(socket.get(), owner_only) != 0 ||
      bind(socket.get(), at.get(), at.length) != 0)
    refuse(std::strerror(errno));
  Listener listener{std::move(socket), at, 0, SocketFile(path)};
  if (listen(listener.socket.get(), SOMAXCONN) != 0) refuse(std::strerror(errno));
  return listener;
}

std::optional<std::string> unix_fault(const std::string& address) {
  const std::string path(unix_path(address));
  struct stat found;
  if (lstat(path.c_str(), &found) == 0 && !S_ISSOCK(found.st_mode)) return other_file;
  const auto folder = folder_of(path);
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return folder.string() + ": " + std::strerror(errno);
  return std::nullopt;
}

}  // namespace stiefel::server
