#include "server/sessions/checkpoints/summary_checkpoint.h"

#include <cstring>

#include "server/sessions/identity.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

constexpr std::string_view magic = "STFLSUM1";
constexpr std::size_t number_bytes = sizeof(std::uint64_t);

void append(std::string& bytes, std::uint64_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), number_bytes);
}

std::uint64_t number_at(std::string_view bytes, std::size_t position) {
  std::uint64_t value;
  std::memcpy(&value, bytes.data() + position, number_bytes);
  return value;
}

}  // namespace

std::string encode_summary(const Session& session, std::uint64_t digest, std::string_view saved) {
  std::string bytes(magic);
  append(bytes, numerics_id().size());
  bytes += numerics_id();
  append(bytes, hash(session.identity()));
  append(bytes, digest);
  bytes += saved;
  append(bytes, hash(bytes));
  return bytes;
}

std::expected<std::string_view, SummaryRefusal> decode_summary(const Session& session,
                                                               std::uint64_t digest,
                                                               std::string_view bytes) {
  const std::unexpected corrupt(SummaryRefusal{SummaryFault::corrupt, {}});
  const std::size_t least = magic.size() + 4 * number_bytes;
  if (bytes.size() < least) return corrupt;
  const auto body = bytes.substr(0, bytes.size() - number_bytes);
  if (number_at(bytes, body.size()) != hash(body) || !body.starts_with(magic)) return corrupt;
  const std::uint64_t length = number_at(body, magic.size());
  if (length > bytes.size() - least) return corrupt;
  std::size_t at = magic.size() + number_bytes;
  const std::string_view numerics = body.substr(at, length);
  at += length;
  if (numerics != numerics_id())
    return std::unexpected(SummaryRefusal{SummaryFault::other_numerics, std::string(numerics)});
  if (number_at(body, at) != hash(session.identity()))
    return std::unexpected(SummaryRefusal{SummaryFault::other_scene, {}});
  if (number_at(body, at + number_bytes) != digest)
    return std::unexpected(SummaryRefusal{SummaryFault::other_request, {}});
  return body.substr(at + 2 * number_bytes);
}

}  // namespace stiefel::server
