#include "server/access/pem.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>

namespace stiefel::server {
namespace {

using Bio = std::unique_ptr<BIO, Release<BIO_free>>;

/// Refuses a key with a passphrase, for which OpenSSL would ask on the terminal.
int no_passphrase(char*, int, int, void*) { return -1; }

Bio reader(const std::string& pem) {
  return Bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

}  // namespace

CleanErrors::~CleanErrors() { ERR_clear_error(); }

std::vector<Certificate> read_chain(const std::string& pem) {
  std::vector<Certificate> chain;
  const Bio bio = reader(pem);
  while (Certificate one{PEM_read_bio_X509(bio.get(), nullptr, no_passphrase, nullptr)})
    chain.push_back(std::move(one));
  const bool ended = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  ERR_clear_error();
  return ended ? std::move(chain) : std::vector<Certificate>();
}

Key read_key(const std::string& pem) {
  return Key(PEM_read_bio_PrivateKey(reader(pem).get(), nullptr, no_passphrase, nullptr));
}

}  // namespace stiefel::server
