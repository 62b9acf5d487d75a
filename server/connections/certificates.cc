#include "server/connections/certificates.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <ctime>
#include <exception>
#include <new>
#include <stdexcept>
#include <thread>

namespace stiefel::server {
namespace {

using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;
/// gRPC would take errors left in OpenSSL's queue of this thread for its own.
struct CleanErrors {
  ~CleanErrors() { ERR_clear_error(); }
};
using Bio = std::unique_ptr<BIO, Release<BIO_free>>;

/// Refuses a key with a passphrase, for which OpenSSL would ask on the terminal.
int no_passphrase(char*, int, int, void*) { return -1; }

Bio reader(const std::string& pem) {
  return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

/// Returns all certificates of a PEM text in order; none if one of them cannot be read.
std::vector<Certificate> read_chain(const std::string& pem) {
  std::vector<Certificate> chain;
  const Bio bio = reader(pem);
  while (Certificate one{PEM_read_bio_X509(bio.get(), nullptr, no_passphrase, nullptr)})
    chain.push_back(std::move(one));
  const bool ended = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  return ended ? std::move(chain) : std::vector<Certificate>();
}

/// Returns the private key of a PEM text; null if there is none or it has a passphrase.
Key read_key(const std::string& pem) {
  return Key(PEM_read_bio_PrivateKey(reader(pem).get(), nullptr, no_passphrase, nullptr));
}

std::chrono::system_clock::time_point expire_time(const Certificate& certificate) {
  std::tm time{};
  ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &time);
  return std::chrono::system_clock::from_time_t(timegm(&time));
}

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

std::vector<std::string> paths_of(const TlsFiles& files) {
  std::vector<std::string> paths = {files.certificate, files.key};
  if (!files.client_ca.empty()) paths.push_back(files.client_ca);
  return paths;
}

std::expected<Certificates, std::string> certificates(const TlsFiles& files,
                                                      const WatchedFiles::Contents& contents) {
  const CleanErrors clean;
  static constexpr const char* flags[] = {"--tls-cert", "--tls-key", "--tls-client-ca"};
  const std::vector<std::string> paths = paths_of(files);
  const auto fault = [&](std::size_t file, const std::string& rule) {
    return std::unexpected(std::string(flags[file]) + ": " + paths[file] + ": " + rule);
  };
  for (std::size_t file = 0; file < 2; ++file)
    if (paths[file].empty())
      return std::unexpected(std::string(flags[file]) +
                             ": absent: TLS needs both --tls-cert and --tls-key");
  for (std::size_t file = 0; file < paths.size(); ++file)
    if (!contents[file]) return fault(file, contents[file].error());

  const std::vector<Certificate> chain = read_chain(*contents[0]);
  if (chain.empty()) return fault(0, "it must hold certificates in PEM");
  const Key key = read_key(*contents[1]);
  if (!key) return fault(1, "it must hold a private key in PEM, without passphrase");
  if (X509_check_private_key(chain.front().get(), key.get()) != 1)
    return fault(1, "it is not the key of the first certificate of " + files.certificate);
  const bool with_clients = paths.size() > 2;
  if (with_clients && read_chain(*contents[2]).empty())
    return fault(2, "it must hold certificates in PEM");
  return Certificates{*contents[0], *contents[1], with_clients ? *contents[2] : "",
                      expire_time(chain.front())};
}

/// The function that gRPC's core calls at every handshake. gRPC 1.51 destroys the previous
/// certificates without a lock, although another handshake may be between this function and their
/// use. Handshakes therefore wait while certificates are exchanged, and for `margin` before and
/// after.
struct CertificateFetcher {
  static constexpr auto margin = std::chrono::milliseconds(20);

  static grpc_ssl_certificate_config_reload_status fetch(
      void* user_data, grpc_ssl_server_certificate_config** config) noexcept {
    auto& served = *static_cast<ServedCertificates*>(user_data);
    const std::lock_guard lock(served.exchange_);
    std::this_thread::sleep_until(served.exchanged_);
    const std::uint64_t version = served.version_;
    if (served.served_ == version) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    if (served.served_ > 0) std::this_thread::sleep_for(margin);
    try {
      const Certificates now = served.current();
      const grpc_ssl_pem_key_cert_pair pair = {now.key.c_str(), now.chain.c_str()};
      // gRPC 1.51 aborts without authorities, even if it asks no client for a certificate.
      const std::string& authorities = now.client_ca.empty() ? now.chain : now.client_ca;
      *config = grpc_ssl_server_certificate_config_create(authorities.c_str(), &pair, 1);
    } catch (const std::exception&) {
      return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_FAIL;  // gRPC keeps the previous certificates
    }
    if (served.served_ > 0) served.exchanged_ = std::chrono::steady_clock::now() + margin;
    served.served_ = version;
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }
};

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

void ServedCertificates::take(const WatchedFiles::Contents& contents) {
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
