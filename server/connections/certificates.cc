#include "server/connections/certificates.h"

#include <grpc/grpc.h>
#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace stiefel::server {
namespace {

/// A deleter that calls OpenSSL's function `release`.
template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const {
    release(object);
  }
};
using Certificate = std::unique_ptr<X509, Release<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Release<EVP_PKEY_free>>;
using Bio = std::unique_ptr<BIO, Release<BIO_free>>;

/// gRPC would take errors left in OpenSSL's queue of this thread for its own.
struct CleanErrors {
  ~CleanErrors() { ERR_clear_error(); }
};

/// Refuses a key with a passphrase, for which OpenSSL would ask on the terminal.
int no_passphrase(char*, int, int, void*) { return -1; }

Bio reader(const std::string& pem) {
  return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

/// Returns the first certificate of a PEM text; null if one of its certificates cannot be read.
Certificate read_chain(const std::string& pem) {
  const CleanErrors clean;
  const Bio bio = reader(pem);
  Certificate first;
  while (Certificate one{PEM_read_bio_X509(bio.get(), nullptr, no_passphrase, nullptr)})
    if (!first) first = std::move(one);
  return ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE ? std::move(first) : nullptr;
}

/// Returns the private key of a PEM text; null if there is none or it has a passphrase.
Key read_key(const std::string& pem) {
  return Key(PEM_read_bio_PrivateKey(reader(pem).get(), nullptr, no_passphrase, nullptr));
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

}  // namespace

ServedCertificates::ServedCertificates(const TlsFiles& files, const Log& log)
    : files_(files), log_(log) {
  for (const auto& [flag, file] :
       {std::pair{"--tls-cert", files.certificate}, {"--tls-key", files.key}})
    if (file.empty())
      throw std::runtime_error(std::string(flag) +
                               ": absent: TLS needs both --tls-cert and --tls-key");
  std::vector<std::string> paths = {files.certificate, files.key};
  if (!files.client_ca.empty()) paths.push_back(files.client_ca);
  watch_.emplace(std::move(paths), log, "certificates",
                 [this](const WatchedFiles::Contents& contents) { take(contents); });
}

void ServedCertificates::take(const WatchedFiles::Contents& contents) {
  const CleanErrors clean;
  const std::string names[] = {"--tls-cert: " + files_.certificate, "--tls-key: " + files_.key,
                               "--tls-client-ca: " + files_.client_ca};
  const auto check = [&](bool holds, std::size_t file, const std::string& rule) {
    if (!holds) throw std::runtime_error(names[file] + ": " + rule);
  };
  for (std::size_t file = 0; file < contents.size(); ++file)
    if (!contents[file]) check(false, file, contents[file].error());
  const Certificate first = read_chain(*contents[0]);
  check(first != nullptr, 0, "it must hold certificates in PEM");
  const Key key = read_key(*contents[1]);
  check(key != nullptr, 1, "it must hold a private key in PEM, without passphrase");
  check(X509_check_private_key(first.get(), key.get()) == 1, 1,
        "it is not the key of the first certificate of " + files_.certificate);
  const bool with_clients = contents.size() > 2;
  check(!with_clients || read_chain(*contents[2]), 2, "it must hold certificates in PEM");
  if (X509_cmp_current_time(X509_get0_notAfter(first.get())) < 0)
    log_.line(Log::Level::warn, "certificate", {{"fault", names[0] + ": expired"}});
  const std::lock_guard lock(mutex_);
  chain_ = *contents[0];
  key_ = *contents[1];
  // gRPC 1.51 aborts without authorities, even if it asks no client for a certificate.
  client_ca_ = with_clients ? *contents[2] : chain_;
  changed_ = true;
}

/// gRPC 1.51 destroys the previous certificates without a lock, although another handshake may be
/// between this function and their use. Handshakes therefore wait while certificates are exchanged,
/// and for `margin` before and after.
grpc_ssl_certificate_config_reload_status ServedCertificates::fetch(
    void* served, grpc_ssl_server_certificate_config** config) noexcept {
  constexpr auto margin = std::chrono::milliseconds(20);
  auto& self = *static_cast<ServedCertificates*>(served);
  const std::lock_guard lock(self.mutex_);
  std::this_thread::sleep_until(self.exchanged_);
  if (!self.changed_) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
  if (self.served_) std::this_thread::sleep_for(margin);
  const grpc_ssl_pem_key_cert_pair pair = {self.key_.c_str(), self.chain_.c_str()};
  *config = grpc_ssl_server_certificate_config_create(self.client_ca_.c_str(), &pair, 1);
  if (self.served_) self.exchanged_ = std::chrono::steady_clock::now() + margin;
  self.changed_ = false;
  self.served_ = true;
  return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
}

std::shared_ptr<grpc::ServerCredentials> ServedCertificates::credentials() {
  const auto clients = files_.client_ca.empty()
                           ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                           : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
  return std::make_shared<ReloadingCredentials>(
      grpc_ssl_server_credentials_create_options_using_config_fetcher(clients, &fetch, this));
}

}  // namespace stiefel::server
