#include "server/access/served_certificates.h"
#include "server/limits/failpoint.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>

#include <exception>
#include <stdexcept>

namespace stiefel::server {

/// The function that gRPC's core calls at every handshake.
struct CertificateFetcher {
  static grpc_ssl_certificate_config_reload_status fetch(
      void* user_data, grpc_ssl_server_certificate_config** config) noexcept {
    auto& served = *static_cast<ServedCertificates*>(user_data);
    const std::uint64_t version = served.version_;
    if (served.served_ == version) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    try {
      const Certificates now = served.current();
      const grpc_ssl_pem_key_cert_pair pair = {now.key.c_str(), now.chain.c_str()};
      // gRPC 1.51 aborts without authorities, even if it asks no client for a certificate.
      const std::string& authorities = now.client_ca.empty() ? now.chain : now.client_ca;
      *config = grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
    } catch (const std::exception&) {
      return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_FAIL;  // gRPC keeps the previous certificates
    }
    served.served_ = version;
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }
};

namespace {

/// Credentials that ask for the certificates at each handshake, which gRPC 1.51 offers in its core
/// but not in its C++ interface.
class ReloadingCredentials final : public grpc::ServerCredentials {
 public:
  explicit ReloadingCredentials(grpc_ssl_server_credentials_options* options)
      : core_(grpc_ssl_server_credentials_create_with_options(options)) {}
  ~ReloadingCredentials() override { grpc_server_credentials_release(core_); }

  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), core_);
  }

  grpc_server_credentials* core_;
};

Certificates checked(const TlsFiles& files, const WatchedFiles::Contents& contents) {
  auto first = certificates(files, contents);
  if (!first) throw std::runtime_error(first.error());
  return *std::move(first);
}

}  // namespace

ServedCertificates::ServedCertificates(const TlsFiles& files, Report report)
    : files_(files), report_(std::move(report)) {
  const auto contents = read_texts(paths_of(files));
  current_ = checked(files, contents);
  watch_.emplace(paths_of(files), contents,
                 [this](const WatchedFiles::Contents& changed) { take(changed); });
}

std::shared_ptr<grpc::ServerCredentials> ServedCertificates::credentials() {
  const auto clients = files_.client_ca.empty()
                           ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                           : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
  return std::make_shared<ReloadingCredentials>(
      grpc_ssl_server_credentials_create_options_using_config_fetcher(
          clients, &CertificateFetcher::fetch, this));
}

Certificates ServedCertificates::current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

void ServedCertificates::take(const WatchedFiles::Contents& contents) {
  failpoint("tls.reload");
  auto changed = certificates(files_, contents);
  if (!changed) return report_(changed.error());
  {
    const std::lock_guard lock(mutex_);
    current_ = *std::move(changed);
    ++version_;
  }
  report_(std::nullopt);
}

}  // namespace stiefel::server
