#include "server/sessions/checkpoints/secrets.h"

#include <openssl/evp.h>
#include <openssl/rand.h>

#include <stdexcept>

namespace stiefel::server {
namespace {

constexpr std::string_view digits = "0123456789abcdef";

/// Fetched once: fetching an algorithm takes longer than digesting a token.
const EVP_MD* algorithm() {
  static EVP_MD* const found = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  return found;
}

void check(bool done, const char* what) {
  if (!done) throw std::runtime_error(std::string("OpenSSL has no ") + what);
}

}  // namespace

Bytes32 sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digest();
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  check(context_ && EVP_DigestInit_ex(context_.get(), algorithm(), nullptr) == 1, "SHA-256");
}

void Sha256::add(std::string_view bytes) {
  check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1, "SHA-256");
}

Bytes32 Sha256::digest() {
  Bytes32 out;
  check(EVP_DigestFinal_ex(context_.get(), out.data(), nullptr) == 1, "SHA-256");
  return out;
}

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Bytes32 random_secret() {
  Bytes32 secret;
  check(RAND_priv_bytes(secret.data(), static_cast<int>(secret.size())) == 1, "random numbers");
  return secret;
}

std::string to_hexadecimal(const Bytes32& bytes) {
  std::string out;
  for (const unsigned char byte : bytes) {
    out += digits[byte >> 4];
    out += digits[byte & 0xF];
  }
  return out;
}

}  // namespace stiefel::server
