#include "server/sessions/checkpoints/summary_checkpoint.h"

#include <algorithm>
#include <cstring>

#include "server/sessions/checkpoints/append.h"
#include "server/sessions/checkpoints/checkpoint_keys.h"
#include "server/sessions/identity.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

constexpr std::string_view summary_magic = "STFLSUM2";
/// The magic without its last character, which is the version of the format.
constexpr std::string_view any_summary_magic = summary_magic.substr(0, summary_magic.size() - 1);
constexpr std::size_t number_bytes = sizeof(std::uint64_t);

std::uint64_t number_at(std::string_view bytes, std::size_t position) {
  std::uint64_t value;
  std::memcpy(&value, bytes.data() + position, number_bytes);
  return value;
}

}  // namespace

std::string encode_summary(const Session& session, std::uint64_t digest, std::string_view saved) {
  const CheckpointKey& key = session.checkpoint_keys().signing();
  std::string bytes(summary_magic);
  bytes += key.name;
  append(bytes, numerics_id().size());
  bytes += numerics_id();
  append(bytes, hash(session.identity()));
  append(bytes, digest);
  bytes += saved;
  append(bytes, hmac_sha256(key.secret, bytes));
  return bytes;
}

std::expected<std::string_view, SummaryRefusal> decode_summary(const Session& session,
                                                               std::uint64_t digest,
                                                               std::string_view bytes) {
  const auto refused = [](SummaryFault fault, std::string_view numerics = {}) {
    return std::unexpected(SummaryRefusal{fault, std::string(numerics)});
  };
  const std::size_t head = summary_magic.size() + CheckpointKey::name_bytes;
  const std::size_t least = head + 3 * number_bytes + sizeof(Bytes32);
  if (bytes.size() < least || !bytes.starts_with(any_summary_magic))
    return refused(SummaryFault::corrupt);
  if (!bytes.starts_with(summary_magic)) return refused(SummaryFault::foreign);
  const CheckpointKey* key =
      session.checkpoint_keys().find(bytes.substr(summary_magic.size(), CheckpointKey::name_bytes));
  if (key == nullptr) return refused(SummaryFault::foreign);
  const auto body = bytes.substr(0, bytes.size() - sizeof(Bytes32));
  Bytes32 mac;
  std::ranges::copy(bytes.substr(body.size()), mac.begin());
  if (!equal_secrets(mac, hmac_sha256(key->secret, body))) return refused(SummaryFault::corrupt);

  const std::uint64_t length = number_at(body, head);
  if (length > bytes.size() - least) return refused(SummaryFault::corrupt);
  std::size_t at = head + number_bytes;
  const std::string_view numerics = body.substr(at, length);
  at += length;
  if (numerics != numerics_id()) return refused(SummaryFault::other_numerics, numerics);
  if (number_at(body, at) != hash(session.identity())) return refused(SummaryFault::other_scene);
  if (number_at(body, at + number_bytes) != digest) return refused(SummaryFault::other_request);
  return body.substr(at + 2 * number_bytes);
}

}  // namespace stiefel::server
