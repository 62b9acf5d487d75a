#pragma once

#include <map>
#include <string>

namespace stiefel::cli {

/// Where the user wrote the fields of a request: in which file, or as which option.
struct Origin {
  std::string file;            ///< the file of the scene or, if `whole_request`, of the request
  bool whole_request = false;  ///< whether the file has the whole request, not only its scene
  bool single_pair = false;    ///< whether the file gives one pair of frames outside of `pairs`
  /// Fields that come from options: {"fields", "--fields"}.
  std::map<std::string, std::string> options = {};

  /// Returns the user's name for a field of the request: "scene.json: initial.Q" for
  /// "scene.initial.Q", "--fields[1]" for "fields[1]".
  std::string place(const std::string& field) const;
};

}  // namespace stiefel::cli
