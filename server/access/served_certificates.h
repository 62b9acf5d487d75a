#pragma once

#include <grpcpp/security/server_credentials.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "server/access/certificates.h"

namespace stiefel::server {

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

  /// Throws std::runtime_error if the files are not valid (certificates.h).
  ServedCertificates(const TlsFiles& files, Report report);
  ServedCertificates(const ServedCertificates&) = delete;
  ServedCertificates& operator=(const ServedCertificates&) = delete;

  /// Returns credentials for a server that this object outlives: TLS 1.2 and 1.3. With
  /// --tls-client-ca the client must have a certificate of one of these authorities.
  std::shared_ptr<grpc::ServerCredentials> credentials();

  Certificates current() const;

 private:
  void take(const WatchedFiles::Contents& contents);

  const TlsFiles files_;
  const Report report_;
  mutable std::mutex mutex_;
  Certificates current_;  // guarded by mutex_
  std::atomic<std::uint64_t> version_ = 1;
  std::atomic<std::uint64_t> served_ = 0;
  std::optional<WatchedFiles> watch_;

  friend struct CertificateFetcher;
};

}  // namespace stiefel::server
