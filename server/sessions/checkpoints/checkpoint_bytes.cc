#include "server/sessions/checkpoints/checkpoint_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "server/limits/failpoint.h"
#include "server/sessions/checkpoints/append.h"
#include "server/sessions/checkpoints/checkpoint_keys.h"
#include "server/sessions/checkpoints/digest.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view checkpoint_magic = "STFLCKP3";
/// The magic without its last character, which is the version of the format.
constexpr std::string_view any_checkpoint_magic =
    checkpoint_magic.substr(0, checkpoint_magic.size() - 1);

/// Reads from the front of the bytes; returns nothing once they run out.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  std::optional<std::string_view> bytes(std::uint64_t count) {
    if (count > left_.size()) return std::nullopt;
    const auto taken = left_.substr(0, count);
    left_.remove_prefix(count);
    return taken;
  }
  std::optional<std::uint64_t> number() {
    const auto taken = bytes(sizeof(std::uint64_t));
    if (!taken) return std::nullopt;
    std::uint64_t value;
    std::memcpy(&value, taken->data(), sizeof value);
    return value;
  }
  std::optional<Bytes32> bytes32() {
    Bytes32 value;
    const auto taken = bytes(value.size());
    if (!taken) return std::nullopt;
    std::ranges::copy(*taken, value.begin());
    return value;
  }
  std::size_t left() const { return left_.size(); }

 private:
  std::string_view left_;
};

}  // namespace

std::string encode_checkpoint(const Session& session, const Simulation& simulation) {
  failpoint("checkpoint.encode");
  std::vector<double> saved(simulation.saved_size());
  simulation.save(saved);
  const CheckpointKey& key = session.checkpoint_keys().signing();
  std::string bytes(checkpoint_magic);
  bytes.reserve(checkpoint_bytes(session));
  bytes += key.name;
  append(bytes, numerics_id().size());
  bytes += numerics_id();
  append(bytes, sha256(session.identity()));
  append(bytes, static_cast<std::uint64_t>(simulation.step()));
  bytes.append(reinterpret_cast<const char*>(saved.data()), saved.size() * sizeof(double));
  append(bytes, hmac_sha256(key.secret, bytes));
  return bytes;
}

std::size_t checkpoint_bytes(const Session& session) {
  constexpr std::size_t numbers = 2;  // length of the numerics id, step
  constexpr std::size_t digests = 2;  // of the scene, and the HMAC
  return checkpoint_magic.size() + CheckpointKey::name_bytes + numerics_id().size() +
         numbers * sizeof(std::uint64_t) + digests * sizeof(Bytes32) +
         session.saved_size() * sizeof(double);
}

std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes) {
  failpoint("checkpoint.decode");
  const std::unexpected corrupt(CheckpointRefusal{CheckpointFault::corrupt, {}});
  const std::unexpected foreign(CheckpointRefusal{CheckpointFault::foreign, {}});
  if (bytes.size() < checkpoint_magic.size() + CheckpointKey::name_bytes + sizeof(Bytes32))
    return corrupt;
  const auto signed_bytes = bytes.substr(0, bytes.size() - sizeof(Bytes32));

  Reader in(signed_bytes);
  const std::string_view format = *in.bytes(checkpoint_magic.size());
  if (!format.starts_with(any_checkpoint_magic)) return corrupt;
  if (format != checkpoint_magic) return foreign;
  const CheckpointKey* key = session.checkpoint_keys().find(*in.bytes(CheckpointKey::name_bytes));
  if (key == nullptr) return foreign;
  const Bytes32 mac = *Reader(bytes.substr(signed_bytes.size())).bytes32();
  if (!equal_secrets(mac, hmac_sha256(key->secret, signed_bytes))) return corrupt;

  const auto length = in.number();
  const auto numerics = in.bytes(length.value_or(0));
  const auto scene = in.bytes32();
  const auto step = in.number();
  if (!length || !numerics || !scene || !step) return corrupt;
  if (*numerics != numerics_id()) {
    return std::unexpected(
        CheckpointRefusal{CheckpointFault::other_numerics, std::string(*numerics)});
  }
  if (*scene != sha256(session.identity())) {
    return std::unexpected(CheckpointRefusal{CheckpointFault::other_scene, {}});
  }
  if (*step > static_cast<std::uint64_t>(Session::max_step)) return corrupt;
  if (in.left() != session.saved_size() * sizeof(double)) return corrupt;

  Checkpoint checkpoint{static_cast<std::int64_t>(*step),
                        std::vector<double>(session.saved_size())};
  std::memcpy(checkpoint.saved.data(), in.bytes(in.left())->data(),
              checkpoint.saved.size() * sizeof(double));
  if (!std::ranges::all_of(checkpoint.saved, [](double x) { return std::isfinite(x); }))
    return corrupt;
  return checkpoint;
}

}  // namespace stiefel::server
