#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace stiefel::cli {

/// Where the user wrote the fields of a request: in which file, or as which option.
struct Origin {
  std::string file;            ///< the file of the scene or, if `whole_request`, of the request
  bool whole_request = false;  ///< whether the file has the whole request, not only its scene
  bool single_pair = false;    ///< whether the file gives one pair of frames outside of `pairs`
  /// Fields that come from options: {"fields", "--fields"}.
  std::map<std::string, std::string> options = {};
  /// Blocks that stand for others, which the user gave: {"initial.M", "initial.Omega"}.
  std::map<std::string, std::string> renamed = {};
  /// Indices of the request's times in the file that the user gave; empty without such a file.
  std::vector<std::size_t> times = {};

  /// Returns the user's name for a field of the request: "scene.json: initial.Q" for
  /// "scene.initial.Q", "--fields[1]" for "fields[1]".
  std::string place(const std::string& field) const;

 private:
  /// Returns "[5]" for "[0]" if the first of the request's times is number 5 in the file.
  std::string index_of_time(const std::string& index) const;
};

}  // namespace stiefel::cli
