#pragma once

#include <chrono>
#include <expected>
#include <string>
#include <vector>

#include "server/access/access_options.h"
#include "server/access/watched_files.h"

namespace stiefel::server {

/// PEM texts that belong together: the chain begins with the certificate of the key.
struct Certificates {
  std::string chain, key, client_ca;
  std::chrono::system_clock::time_point expire_time;  ///< of the first certificate of the chain
};

/// The paths of the files in the order in which `certificates` takes their contents; without that
/// of the clients' authorities if there is none.
std::vector<std::string> paths_of(const TlsFiles& files);

/// The files' contents (of `paths_of`) as certificates. The error names the flag, the file and the
/// rule: a file that cannot be read, no PEM, a key of another certificate. It shows nothing of the
/// key.
std::expected<Certificates, std::string> certificates(const TlsFiles& files,
                                                      const WatchedFiles::Contents& contents);

}  // namespace stiefel::server
