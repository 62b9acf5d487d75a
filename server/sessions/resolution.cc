#include "server/sessions/resolution.h"

#include <algorithm>

namespace stiefel::server {
namespace {

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
