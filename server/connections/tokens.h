#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/scheduling/principal.h"
#include "server/sessions/checkpoints/secrets.h"

namespace stiefel::server {

/// The tokens that a server accepts, each as its SHA-256: reading this object or its file yields no
/// token with which to call.
class TokenTable {
 public:
  struct Parsed;
  /// Parses the text of a token file: in each line a principal's name, 1 to 128 characters of
  /// [A-Za-z0-9._-], and 64 hexadecimal digits. Ignores empty lines and lines that begin with #. A
  /// principal may have several lines.
  static Parsed parse(std::string_view text);

  /// Returns the principal whose token has that digest; null if there is none.
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
  TokenTable table;                 ///< the valid lines
  std::vector<std::string> faults;  ///< each gives the number of its line, never the text
};

/// A new token of 256 random bits, and the line for the file that admits it.
struct NewToken {
  std::string token;
  std::string line;
};
/// Throws std::runtime_error if `name` is not a valid name of a principal.
NewToken make_token(std::string_view name);

/// Returns the SHA-256 of the token in "Bearer TOKEN", the value of the metadata `authorization`;
/// nothing for a value of another form. The case of Bearer does not matter.
std::optional<Bytes32> digest_of_bearer(std::string_view authorization);

}  // namespace stiefel::server
