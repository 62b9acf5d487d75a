#pragma once

#include <span>
#include <string_view>

// Files that the build makes part of the program (stiefel_embed).
namespace stiefel::cli {

struct EmbeddedFile {
  std::string_view name;  ///< "toutatis.json"
  std::string_view text;
};

/// The scenes of client/examples/scenes, and frames to connect.
std::span<const EmbeddedFile> examples();

/// The page of `stiefel report`: page.html, in which "@DATA@" stands for its data as JSON and
/// @FILE@ for each of the other files.
std::span<const EmbeddedFile> pages();

}  // namespace stiefel::cli
