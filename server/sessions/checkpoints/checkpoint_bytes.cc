#include "server/sessions/checkpoints/checkpoint_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {
namespace {

static_assert(std::endian::native == std::endian::little);

std::string_view bytes_of(const auto& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof numbers[0]};
}
std::string_view bytes_of(const std::uint64_t& number) {
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

std::unexpected<CheckpointRefusal> refused(CheckpointFault fault, std::string_view numerics = {}) {
  return std::unexpected(CheckpointRefusal{fault, std::string(numerics)});
}

/// Removes the first eight bytes, of which there must be as many, and returns them as a number.
std::uint64_t take_number(std::string_view& bytes) {
  std::uint64_t value;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return value;
}

/// Returns the bytes of a checkpoint beside its content.
std::size_t frame_bytes(const Session& session) {
  return state_format.size() + sizeof(std::uint64_t) + numerics_id().size() +
         session.identity().size() + sizeof(Bytes32);
}

}  // namespace

std::string seal_checkpoint(const Session& session, std::string_view format,
                            std::initializer_list<std::string_view> content) {
  std::size_t size = frame_bytes(session);
  for (const std::string_view part : content) size += part.size();
  std::string bytes(format);
  bytes.reserve(size);
  bytes += bytes_of(numerics_id().size());
  bytes += numerics_id();
  bytes += session.identity();
  for (const std::string_view part : content) bytes += part;
  return bytes += bytes_of(sha256(bytes));
}

std::expected<std::string_view, CheckpointRefusal> verify_checkpoint(const Session& session,
                                                                     std::string_view format,
                                                                     std::string_view bytes) {
  using enum CheckpointFault;
  if (bytes.size() < format.size() + sizeof(std::uint64_t) + sizeof(Bytes32) ||
      !bytes.starts_with(format))
    return refused(corrupt);
  std::string_view left = bytes.substr(0, bytes.size() - sizeof(Bytes32));
  if (bytes.substr(left.size()) != bytes_of(sha256(left))) return refused(corrupt);

  left.remove_prefix(format.size());
  const std::uint64_t length = take_number(left);
  if (length > left.size()) return refused(corrupt);
  const std::string_view numerics = left.substr(0, length);
  left.remove_prefix(length);
  if (numerics != numerics_id()) return refused(other_numerics, numerics);
  if (!left.starts_with(session.identity())) return refused(other_scene);
  return left.substr(session.identity().size());
}

std::string encode_checkpoint(const Session& session, const Simulation& simulation) {
  std::vector<double> saved(simulation.saved_size());
  simulation.save(saved);
  return encode_checkpoint(session, simulation.step(), saved);
}

std::string encode_checkpoint(const Session& session, std::int64_t step,
                              std::span<const double> saved) {
  const auto number = static_cast<std::uint64_t>(step);
  return seal_checkpoint(session, state_format, {bytes_of(number), bytes_of(saved)});
}

std::size_t checkpoint_bytes(const Session& session) {
  return frame_bytes(session) + sizeof(std::uint64_t) + session.saved_size() * sizeof(double);
}

std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes) {
  auto content = verify_checkpoint(session, state_format, bytes);
  if (!content) return std::unexpected(std::move(content.error()));
  std::vector<double> saved(session.saved_size());
  if (content->size() != sizeof(std::uint64_t) + bytes_of(saved).size())
    return refused(CheckpointFault::corrupt);
  const std::uint64_t step = take_number(*content);
  std::memcpy(saved.data(), content->data(), content->size());
  if (step > static_cast<std::uint64_t>(Session::max_step) ||
      !std::ranges::all_of(saved, [](double x) { return std::isfinite(x); }))
    return refused(CheckpointFault::corrupt);
  return Checkpoint{static_cast<std::int64_t>(step), std::move(saved)};
}

}  // namespace stiefel::server
