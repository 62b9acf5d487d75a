#include "server/sessions/checkpoints/digest.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <stdexcept>

namespace stiefel::server {
namespace {

constexpr std::string_view digits = "0123456789abcdef";

const unsigned char* data(std::string_view bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

/// Fetched once: fetching an algorithm takes longer than digesting a token.
const EVP_MD* algorithm() {
  static EVP_MD* const found = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  return found;
}

std::optional<unsigned> value_of(char digit) {
  if (digit >= 'A' && digit <= 'F') digit = static_cast<char>(digit - 'A' + 'a');
  const std::size_t value = digits.find(digit);
  return value == digits.npos ? std::nullopt : std::optional(static_cast<unsigned>(value));
}

}  // namespace

Bytes32 sha256(std::string_view bytes) {
  Bytes32 digest;
  if (EVP_Digest(data(bytes), bytes.size(), digest.data(), nullptr, algorithm(), nullptr) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
  return digest;
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
  if (!context_ || EVP_DigestInit_ex(context_.get(), algorithm(), nullptr) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
}

void Sha256::add(std::string_view bytes) {
  if (EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
}

Bytes32 Sha256::digest() {
  Bytes32 out;
  if (EVP_DigestFinal_ex(context_.get(), out.data(), nullptr) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
  return out;
}

void Sha256::Free::operator()(evp_md_ctx_st* context) const { EVP_MD_CTX_free(context); }

Bytes32 hmac_sha256(const Bytes32& key, std::string_view bytes) {
  Bytes32 mac;
  std::size_t size = 0;
  if (EVP_Q_mac(nullptr, "HMAC", nullptr, "SHA256", nullptr, key.data(), key.size(), data(bytes),
                bytes.size(), mac.data(), mac.size(), &size) == nullptr ||
      size != mac.size())
    throw std::runtime_error("OpenSSL has no HMAC-SHA256");
  return mac;
}

Bytes32 random_secret() {
  Bytes32 secret;
  if (RAND_priv_bytes(secret.data(), static_cast<int>(secret.size())) != 1)
    throw std::runtime_error("OpenSSL has no random numbers");
  return secret;
}

bool equal_secrets(const Bytes32& a, const Bytes32& b) {
  return CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string to_hexadecimal(const Bytes32& bytes) {
  std::string out;
  for (const unsigned char byte : bytes) {
    out += digits[byte >> 4];
    out += digits[byte & 0xF];
  }
  return out;
}

std::optional<Bytes32> from_hexadecimal(std::string_view text) {
  Bytes32 bytes;
  if (text.size() != 2 * bytes.size()) return std::nullopt;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const auto high = value_of(text[2 * i]), low = value_of(text[2 * i + 1]);
    if (!high || !low) return std::nullopt;
    bytes[i] = static_cast<unsigned char>(16 * *high + *low);
  }
  return bytes;
}

}  // namespace stiefel::server
