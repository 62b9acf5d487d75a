#include "server/access/certificates.h"

#include <openssl/asn1.h>
#include <openssl/x509.h>

#include <ctime>

#include "server/access/pem.h"

namespace stiefel::server {
namespace {

std::chrono::system_clock::time_point expire_time(const Certificate& certificate) {
  std::tm time{};
  ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &time);
  return std::chrono::system_clock::from_time_t(timegm(&time));
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

}  // namespace stiefel::server
