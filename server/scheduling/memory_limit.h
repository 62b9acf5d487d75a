#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace stiefel::server {

/// The least memory with which a server works: 64 MiB, in bytes.
inline constexpr std::uint64_t least_memory = std::uint64_t{64} << 20;
/// Reads a number of bytes such as "268435456", "256M" or "1.5G", where K, M, G and T stand for
/// powers of 1024. Returns nothing for any other text and for less than `least` bytes.
std::optional<std::uint64_t> read_bytes(std::string_view text, std::uint64_t least = least_memory);

/// Returns the smaller of the machine's memory and the limit of this process's control group and of
/// those above it (memory.max, cgroups of version 2), in bytes. `root` holds proc and sys; tests
/// set it.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

/// Returns the resident memory of this process in bytes; 0 where it is not known.
std::uint64_t resident_bytes();

/// Returns the memory that a server takes by default: three quarters of the available memory.
std::uint64_t default_memory();

/// Returns the largest message that a server with `memory` bytes accepts: a sixteenth of them, at
/// most 256 MiB.
inline std::uint64_t largest_message(std::uint64_t memory) {
  return std::min<std::uint64_t>(256 << 20, memory / 16);
}

/// Return the parts of the memory set aside for what gRPC has read and not handed over yet (a
/// quarter), for the program itself (an eighth, at most 32 MiB), and for sessions and calls (the
/// rest).
inline std::uint64_t grpc_share(std::uint64_t memory) { return memory / 4; }
inline std::uint64_t program_share(std::uint64_t memory) {
  return std::min<std::uint64_t>(32 << 20, memory / 8);
}
inline std::uint64_t session_share(std::uint64_t memory) {
  return memory - grpc_share(memory) - program_share(memory);
}

/// Makes malloc give blocks of at least 512 KiB back to the system when they are freed, and have
/// two arenas a core. For programs, at their start; a library leaves the settings of its host
/// alone.
void keep_little_freed_memory();

/// Gives freed memory back to the system if the process holds more than `taken` bytes by 64 MiB (an
/// eighth of `limit`, if that is less) and by an eighth of what is taken.
void give_back_freed_memory(std::uint64_t taken, std::uint64_t limit);

/// Gives back the pages below the stack of this thread. A step of a large body leaves megabytes of
/// them, which a thread that waits would hold.
void give_back_unused_stack();

}  // namespace stiefel::server
