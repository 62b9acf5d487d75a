#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace stiefel {

/// Returns the Damerau–Levenshtein distance: the least number of insertions, deletions,
/// substitutions and exchanges of neighbours (no character edited twice) that turn `a` into `b`.
/// ASCII upper and lower case count as equal, and so do '-' and '_'.
constexpr std::size_t name_distance(std::string_view a, std::string_view b) {
  const auto folded = [](char c) {
    return c == '-' ? '_' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  };
  const auto same = [&](std::size_t i, std::size_t j) { return folded(a[i]) == folded(b[j]); };
  const std::size_t m = a.size(), n = b.size();
  std::vector distance(m + 1, std::vector<std::size_t>(n + 1));  // of the first i and j characters
  for (std::size_t i = 0; i <= m; ++i)
    for (std::size_t j = 0; j <= n; ++j) {
      std::size_t& d = distance[i][j] = i + j;
      if (i == 0 || j == 0) continue;
      d = std::min({distance[i - 1][j] + 1, distance[i][j - 1] + 1,
                    distance[i - 1][j - 1] + !same(i - 1, j - 1)});
      if (i > 1 && j > 1 && same(i - 1, j - 2) && same(i - 2, j - 1))
        d = std::min(d, distance[i - 2][j - 2] + 1);
    }
  return distance[m][n];
}

/// Returns the name in a list (of items whose name is `name(item)`) that `given` most likely stands
/// for; nullopt when no name is near. A name is near at a distance of at most 2 and less than half
/// the longer name, or if one of the two names, with 3 or more characters, is the beginning of the
/// other. Of several near names the nearest is returned, of equally near ones the first. `given`
/// may be of any length: only its first 64 characters count.
template <std::ranges::input_range Items, class Name = std::identity>
constexpr std::optional<std::string> near_name(std::string_view given, const Items& known,
                                               Name name = {}) {
  constexpr std::size_t most = 2, least_beginning = 3, longest = 64;
  given = given.substr(0, longest);
  std::optional<std::string> nearest;
  std::size_t least = longest;
  for (const auto& item : known) {
    const auto candidate = std::string(std::invoke(name, item));
    const std::size_t shorter = std::min(given.size(), candidate.size());
    const std::size_t longer = std::max(given.size(), candidate.size());
    const std::size_t distance = name_distance(given, candidate);
    const bool close = distance <= most && 2 * distance < longer;
    const bool beginning =
        shorter >= least_beginning && distance == longer - shorter &&
        name_distance(given.substr(0, shorter), candidate.substr(0, shorter)) == 0;
    if (!(close || beginning) || distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

/// Lists the names of the items: "Q, P, M".
template <class Items, class Name>
std::string listed(const Items& items, Name name) {
  std::string out;
  for (const auto& item : items)
    out += (out.empty() ? "" : ", ") + std::string(std::invoke(name, item));
  return out;
}

/// Returns "; did you mean NAME?", for the end of a rule, or nothing when no name is near.
template <std::ranges::input_range Items, class Name = std::identity>
std::string did_you_mean(std::string_view given, const Items& known, Name name = {}) {
  const auto nearest = near_name(given, known, std::move(name));
  return nearest ? "; did you mean " + *nearest + "?" : "";
}

}  // namespace stiefel
