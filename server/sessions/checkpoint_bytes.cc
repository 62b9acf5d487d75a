#include "server/sessions/checkpoint_bytes.h"

#include <bit>
#include <cstring>
#include <optional>

#include "server/sessions/identity.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view magic = "STFLCKP2";

void append(std::string& bytes, std::uint64_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Takes from the front of what is left; nothing once it runs out.
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
  std::size_t left() const { return left_.size(); }

 private:
  std::string_view left_;
};

}  // namespace

std::string encode_checkpoint(const Session& session, const Simulation& simulation) {
  std::vector<double> saved(simulation.saved_size());
  simulation.save(saved);
  std::string bytes(magic);
  append(bytes, numerics_id().size());
  bytes += numerics_id();
  append(bytes, hash(session.identity()));
  append(bytes, static_cast<std::uint64_t>(simulation.step()));
  bytes.append(reinterpret_cast<const char*>(saved.data()), saved.size() * sizeof(double));
  append(bytes, hash(bytes));
  return bytes;
}

std::size_t checkpoint_bytes(const Session& session) {
  constexpr std::size_t numbers = 4;  // length of the numerics id, scene, step, checksum
  return magic.size() + numerics_id().size() + numbers * sizeof(std::uint64_t) +
         session.saved_size() * sizeof(double);
}

std::expected<Checkpoint, CheckpointRefusal> decode_checkpoint(const Session& session,
                                                               std::string_view bytes) {
  const std::unexpected corrupt(CheckpointRefusal{CheckpointFault::corrupt, {}});
  if (bytes.size() < magic.size() + sizeof(std::uint64_t)) return corrupt;
  const auto body = bytes.substr(0, bytes.size() - sizeof(std::uint64_t));
  if (Reader(bytes.substr(body.size())).number() != hash(body)) return corrupt;

  Reader in(body);
  if (in.bytes(magic.size()) != magic) return corrupt;
  const auto length = in.number();
  const auto numerics = in.bytes(length.value_or(0));
  const auto scene = in.number();
  const auto step = in.number();
  if (!length || !numerics || !scene || !step) return corrupt;
  if (*numerics != numerics_id()) {
    return std::unexpected(
        CheckpointRefusal{CheckpointFault::other_numerics, std::string(*numerics)});
  }
  if (*scene != hash(session.identity())) {
    return std::unexpected(CheckpointRefusal{CheckpointFault::other_scene, {}});
  }
  if (*step > static_cast<std::uint64_t>(Session::max_step)) return corrupt;
  if (in.left() != session.saved_size() * sizeof(double)) return corrupt;

  Checkpoint checkpoint{static_cast<std::int64_t>(*step),
                        std::vector<double>(session.saved_size())};
  std::memcpy(checkpoint.saved.data(), in.bytes(in.left())->data(),
              checkpoint.saved.size() * sizeof(double));
  return checkpoint;
}

}  // namespace stiefel::server
