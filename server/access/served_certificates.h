#pragma once

#include <grpcpp/security/server_credentials.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "server/access/certificates.h"

namespace stiefel::server {

/// The certificates of a server, read again when the files change. gRPC takes the newest ones at a
/// connection's handshake; connections that exist keep theirs, so that an exchange ends no call.
///
/// gRPC's own FileWatcherCertificateProvider (1.51) gives up its certificates before it looks at
/// new ones: between the writing of a certificate and that of its key, every handshake would fail.
/// Here only files that belong together replace those before.
class ServedCertificates {
 public:
  /// Hears why new files are not taken, or nothing where they are.
  using Report = std::function<void(const std::optional<std::string>& fault)>;

  /// Throws std::runtime_error where the files are none (certificates.h).
  ServedCertificates(const TlsFiles& files, Report report);
  ServedCertificates(const ServedCertificates&) = delete;
  ServedCertificates& operator=(const ServedCertificates&) = delete;

  /// For a server that this object outlives. TLS 1.2 and 1.3; with --tls-client-ca the client must
  /// have a certificate of one of these authorities.
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
