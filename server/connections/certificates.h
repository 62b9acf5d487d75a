#pragma once

#include <grpc/grpc_security.h>
#include <grpcpp/security/server_credentials.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "server/connections/access_options.h"
#include "server/connections/log.h"
#include "server/connections/watched_files.h"

namespace stiefel::server {

/// The certificates of a server, read again when their files change. gRPC takes the newest ones at
/// the handshake of a connection; existing connections keep theirs, so that a change ends no call.
///
/// gRPC's own FileWatcherCertificateProvider (1.51) drops its certificates before it reads new
/// ones, so that every handshake fails between the writing of a certificate and of its key. Here
/// new files replace the old ones only when they belong together.
class ServedCertificates {
 public:
  /// Throws std::runtime_error if the files are not valid: the error names the flag, the file and
  /// the rule that it breaks, and never shows the key. Later the log tells of files at fault. Warns
  /// of a certificate that has expired.
  ServedCertificates(const TlsFiles& files, const Log& log);
  ServedCertificates(const ServedCertificates&) = delete;
  ServedCertificates& operator=(const ServedCertificates&) = delete;

  /// Returns credentials for a server that this object outlives: TLS 1.2 and 1.3. With
  /// --tls-client-ca the client must have a certificate of one of these authorities.
  std::shared_ptr<grpc::ServerCredentials> credentials();

 private:
  void take(const WatchedFiles::Contents& contents);
  /// gRPC's core calls it at every handshake.
  static grpc_ssl_certificate_config_reload_status fetch(
      void* served, grpc_ssl_server_certificate_config** config) noexcept;

  const TlsFiles files_;
  const Log& log_;
  std::mutex mutex_;  // guards what follows
  /// PEM texts that belong together: the chain starts with the certificate of the key.
  std::string chain_, key_, client_ca_;
  bool changed_ = true, served_ = false;               // whether gRPC lacks these, and has any
  std::chrono::steady_clock::time_point exchanged_{};  // when gRPC has exchanged them
  std::optional<WatchedFiles> watch_;
};

}  // namespace stiefel::server
