#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// The least that a server works with, in bytes: 64 MiB.
inline constexpr std::uint64_t least_memory = std::uint64_t{64} << 20;
/// "268435456", "256M", "1.5G": a number and K, M, G or T for powers of 1024. Nothing for anything
/// else, and for less than `least`.
std::optional<std::uint64_t> read_bytes(std::string_view text, std::uint64_t least = least_memory);

/// The smaller of the machine's memory and the limit of the control group of this process, version
/// 2 (memory.max, of every group above it too) or 1 (memory.limit_in_bytes). `root`: of /proc and
/// /sys, for tests.
std::uint64_t available_memory(const std::filesystem::path& root = "/");

/// Three quarters of the available memory: what a server takes unless told.
std::uint64_t default_memory();

/// The largest message that a server with so much memory accepts: a sixteenth, at most 256 MiB.
std::uint64_t largest_message(std::uint64_t memory);

/// Parts of the memory: for what gRPC reads and has not handed over yet, and for the program
/// itself.
std::uint64_t grpc_share(std::uint64_t memory);
std::uint64_t program_share(std::uint64_t memory);

}  // namespace stiefel::server
