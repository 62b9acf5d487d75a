#include "server/sessions/identity.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>

#include "server/sessions/checkpoints/secrets.h"
#include "stiefel/scene_fields.h"
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

template <class T>
bool there(const std::optional<T>& value) {
  return value.has_value();
}
template <class T>
bool there(const T& value) {
  return !value.empty();
}

template <class T>
void add_digest(const std::string& path, const T& value, FieldDigests& out) {
  Writer of_value;
  of_value.put(value);
  if (there(value)) out.emplace_back(path, of_value.digest());
}
void add_digest(const std::string& path, const std::optional<BodyDescription>& body,
                FieldDigests& out) {
  if (!body) return;
  out.emplace_back(path, "");
  for_each_field<BodyDescription>([&](const auto& field) {
    add_digest(path + "." + std::string(field.name), (*body).*field.member, out);
  });
}

const std::string* find(const FieldDigests& digests, const std::string& path) {
  const auto found = std::ranges::find(digests, path, &FieldDigests::value_type::first);
  return found == digests.end() ? nullptr : &found->second;
}

/// Whether the path is a part, such as "body.moments", of a field that is absent from `digests`.
bool within_absent(const std::string& path, const FieldDigests& digests) {
  const std::size_t dot = path.find('.');
  return dot != path.npos && !find(digests, path.substr(0, dot));
}

}  // namespace

std::string identity_of(const SceneDescription& resolved) {
  Writer out;
  out.put(resolved);
  return out.digest();
}

FieldDigests field_digests(const SceneDescription& description) {
  FieldDigests out;
  for_each_field<SceneDescription>([&](const auto& field) {
    add_digest(std::string(field.name), description.*field.member, out);
  });
  return out;
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

bool Difference::fills_in(std::string_view path) const {
  return std::ranges::any_of(filled_in, [&](const std::string& field) {
    return path.starts_with(field) && (path.size() == field.size() || path[field.size()] == '.');
  });
}

Difference difference(const FieldDigests& given, const FieldDigests& resolved) {
  Difference out;
  for (const auto& [path, digest] : resolved) {
    const std::string* before = find(given, path);
    if (before ? *before != digest : !within_absent(path, given)) out.filled_in.push_back(path);
  }
  for (const auto& [path, digest] : given)
    if (!find(resolved, path) && !within_absent(path, resolved)) out.cleared.push_back(path);
  return out;
}

Difference difference(const SceneDescription& given, const SceneDescription& resolved) {
  return difference(field_digests(given), field_digests(resolved));
}

}  // namespace stiefel::server
