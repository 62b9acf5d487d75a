#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/sessions/checkpoints/digest.h"
#include "server/sessions/principal.h"

namespace stiefel::server {

/// The tokens that a server takes, as the SHA-256 of each. It holds no token, so that whoever reads
/// it or its file cannot call.
class TokenTable {
 public:
  struct Parsed;
  /// From a file's text: a principal's name, 1 to 128 of [A-Za-z0-9._-], and 64 hexadecimal digits
  /// a line; empty lines and those that begin with # do not count. A principal may have several
  /// lines.
  static Parsed parse(std::string_view text);

  /// The principal whose token has that digest, or null.
  const Principal* find(const Bytes32& digest) const;
  std::size_t size() const { return principals_.size(); }

 private:
  struct Hash {
    std::size_t operator()(const Bytes32& digest) const;
  };
  struct Equal {
    bool operator()(const Bytes32& a, const Bytes32& b) const { return equal_secrets(a, b); }
  };
  std::unordered_map<Bytes32, Principal, Hash, Equal> principals_;
};

struct TokenTable::Parsed {
  TokenTable table;                 ///< of the lines without fault
  std::vector<std::string> faults;  ///< each names its line and does not show it
};

/// A new token of 256 random bits, and the line that admits it to the file.
struct NewToken {
  std::string token;
  std::string line;
};
/// Throws std::runtime_error for what is no name of a principal.
NewToken make_token(std::string_view name);

/// SHA-256 of the token in "Bearer TOKEN", the value of the metadata `authorization`; nothing where
/// it has another form. The word Bearer may have capitals or not.
std::optional<Bytes32> digest_of_bearer(std::string_view authorization);

}  // namespace stiefel::server
