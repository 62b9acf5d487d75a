#include "server/sessions/identity.h"

#include <array>
#include <cstdio>
#include <span>

#include "server/sessions/checkpoints/secrets.h"
#include "server/sessions/scene_fields.h"
#include "stiefel/version.h"

namespace stiefel::server {
namespace {

/// Hashes values, each after a prefix that gives its length.
class Writer {
 public:
  void put(std::uint64_t value) {
    hash_.add({reinterpret_cast<const char*>(&value), sizeof value});
  }
  void put(int value) { put(static_cast<std::uint64_t>(value)); }
  void put(double value) { doubles({&value, 1}); }
  void put(const std::string& value) {
    put(value.size());
    hash_.add(value);
  }
  void put(const std::vector<double>& values) {
    put(values.size());
    doubles(values);
  }
  void put(const RowMatrix& value) {
    put(static_cast<std::uint64_t>(value.rows()));
    put(static_cast<std::uint64_t>(value.cols()));
    doubles({value.data(), static_cast<std::size_t>(value.size())});
  }
  void put(const std::map<std::string, Block>& blocks) {
    put(blocks.size());
    for (const auto& [name, block] : blocks) {
      put(name);
      put(block.values);
      put(block.imaginary);
    }
  }
  template <class Value>
  void put(const std::optional<Value>& value) {
    put(std::uint64_t{value.has_value()});
    if (value) put(*value);
  }
  template <Description T>
  void put(const T& description) {
    for_each_field<T>([&](const auto& field) { put(description.*field.member); });
  }
  std::string digest() {
    const Bytes32 bytes = hash_.digest();
    return {bytes.begin(), bytes.end()};
  }

 private:
  void doubles(std::span<const double> values) {
    hash_.add({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  }

  Sha256 hash_;
};

}  // namespace

std::string identity_of(const SceneDescription& resolved) {
  Writer out;
  out.put(resolved);
  return out.digest();
}

std::uint64_t hash(std::string_view bytes) {
  std::uint64_t value = 0xcbf29ce484222325;
  for (const char byte : bytes) {
    value ^= static_cast<unsigned char>(byte);
    value *= 0x100000001b3;
  }
  return value;
}

const std::string& numerics_id() {
  static const std::string id = [] {
    std::array<char, 17> digits;
    std::snprintf(digits.data(), digits.size(), "%016llx",
                  static_cast<unsigned long long>(hash(build_fingerprint())));
    return std::string(digits.data());
  }();
  return id;
}

}  // namespace stiefel::server
