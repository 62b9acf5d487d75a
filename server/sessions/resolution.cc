#include "server/sessions/resolution.h"

#include <algorithm>
#include <cstring>

#include "engine/simulation/scene/scene_fields.h"

namespace stiefel::server {
namespace {

bool same(const double* a, const double* b, std::size_t count) {
  return count == 0 || std::memcmp(a, b, count * sizeof(double)) == 0;
}
bool same(const std::string& a, const std::string& b) { return a == b; }
bool same(int a, int b) { return a == b; }
bool same(double a, double b) { return same(&a, &b, 1); }
bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && same(a.data(), b.data(), a.size());
}
bool same(const RowMatrix& a, const RowMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         same(a.data(), b.data(), static_cast<std::size_t>(a.size()));
}
bool same(const std::map<std::string, Block>& a, const std::map<std::string, Block>& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
    return x.first == y.first && same(x.second.values, y.second.values) &&
           same(x.second.imaginary, y.second.imaginary);
  });
}
template <class T>
bool same(const std::optional<T>& a, const std::optional<T>& b);
template <Description T>
bool same(const T& a, const T& b) {
  bool all = true;
  for_each_field<T>(
      [&](const auto& field) { all = all && same(a.*field.member, b.*field.member); });
  return all;
}
template <class T>
bool same(const std::optional<T>& a, const std::optional<T>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

template <class T>
bool there(const std::optional<T>& value) {
  return value.has_value();
}
template <class T>
bool there(const T& value) {
  return !value.empty();
}

struct Comparison {
  Difference out;

  template <Description T>
  void compare(const std::string& within, const T& given, const T& resolved) {
    for_each_field<T>([&](const auto& field) {
      compare_field(within + std::string(field.name), given.*field.member, resolved.*field.member);
    });
  }

 private:
  template <class T>
  void compare_field(const std::string& path, const T& given, const T& resolved) {
    if (same(given, resolved)) return;
    (there(resolved) ? out.filled_in : out.cleared).push_back(path);
  }
  void compare_field(const std::string& path, const std::optional<BodyDescription>& given,
                     const std::optional<BodyDescription>& resolved) {
    if (given && resolved)
      compare(path + ".", *given, *resolved);
    else if (!same(given, resolved))
      (resolved ? out.filled_in : out.cleared).push_back(path);
  }
};

}  // namespace

bool Difference::fills_in(std::string_view path) const {
  return std::ranges::any_of(filled_in, [&](const std::string& field) {
    return path.starts_with(field) && (path.size() == field.size() || path[field.size()] == '.');
  });
}

Difference difference(const SceneDescription& given, const SceneDescription& resolved) {
  Comparison comparison;
  comparison.compare("", given, resolved);
  return std::move(comparison.out);
}

}  // namespace stiefel::server
