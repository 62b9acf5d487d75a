#pragma once

#include <chrono>
#include <expected>
#include <string>
#include <vector>

#include "server/access/access_options.h"
#include "server/access/watched_files.h"

namespace stiefel::server {

/// PEM texts that belong together: the chain starts with the certificate of the key.
struct Certificates {
  std::string chain, key, client_ca;
  std::chrono::system_clock::time_point expire_time;  ///< of the first certificate of the chain
};

/// Returns the paths of the files in the order in which `certificates` expects their contents;
/// without the clients' authorities if that path is empty.
std::vector<std::string> paths_of(const TlsFiles& files);

/// Reads the certificates from `contents`, those of the files that `paths_of` lists. The error
/// names the flag, the file and the rule that it breaks: unreadable, not PEM, the key of another
/// certificate. It never shows the key.
std::expected<Certificates, std::string> certificates(const TlsFiles& files,
                                                      const WatchedFiles::Contents& contents);

}  // namespace stiefel::server
