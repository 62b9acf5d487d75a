#pragma once

#include <map>
#include <string>

namespace stiefel::cli {

/// Where the user wrote what a command asks of the server.
struct Origin {
  std::string file;            ///< of the scene, or of the whole request
  bool whole_request = false;  ///< the file is the request's
  bool single_pair = false;    ///< its one pair of frames is not in the list `pairs`
  /// The other sources of the request's fields: {"fields", "--fields"}.
  std::map<std::string, std::string> options = {};

  /// The place of a request's field: "scene.initial.Q" is "scene.json: initial.Q", and "fields[1]"
  /// "--fields[1]".
  std::string place(const std::string& field) const;
};

}  // namespace stiefel::cli
