#pragma once

#include <grpcpp/security/server_credentials.h>
#include <openssl/ssl.h>

#include <atomic>
#include <chrono>
#include <expected>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/connections/access_options.h"
#include "server/connections/watched_files.h"

namespace stiefel::server {

/// A deleter that calls OpenSSL's function `release`.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const {
    release(object);
  }
};
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

/// The certificates of a server, read again when their files change. gRPC takes the newest ones at
/// the handshake of a connection; existing connections keep theirs, so that a change ends no call.
///
/// gRPC's own FileWatcherCertificateProvider (1.51) drops its certificates before it reads new
/// ones, so that every handshake fails between the writing of a certificate and of its key. Here
/// new files replace the old ones only when they belong together.
class ServedCertificates {
 public:
  /// Is called with the reason why new files are not used, or with nothing when they are.
  using Report = std::function<void(const std::optional<std::string>& fault)>;

  /// Throws std::runtime_error if the files are not valid.
  ServedCertificates(const TlsFiles& files, Report report);
  ServedCertificates(const ServedCertificates&) = delete;
  ServedCertificates& operator=(const ServedCertificates&) = delete;

  /// Returns credentials for a server that this object outlives: TLS 1.2 and 1.3. With
  /// --tls-client-ca the client must have a certificate of one of these authorities.
  std::shared_ptr<grpc::ServerCredentials> credentials();

  Certificates current() const {
    const std::lock_guard lock(mutex_);
    return current_;
  }

 private:
  void take(const WatchedFiles::Contents& contents);

  const TlsFiles files_;
  const Report report_;
  mutable std::mutex mutex_;
  Certificates current_;  // guarded by mutex_
  std::atomic<std::uint64_t> version_ = 1;
  std::mutex exchange_;
  std::uint64_t served_ = 0;                           // the version that gRPC has
  std::chrono::steady_clock::time_point exchanged_{};  // when gRPC uses it; guarded by exchange_
  std::optional<WatchedFiles> watch_;

  friend struct CertificateFetcher;
};

}  // namespace stiefel::server
