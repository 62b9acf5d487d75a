#pragma once

#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace stiefel {

/// Returns the name of one invariant of a family: "casimirs[0]", "manakov[3,1]".
std::string indexed(std::string_view family, long i);
std::string indexed(std::string_view family, long i, long j);

/// Collects the values of a state's invariants that are asked for: families ("manakov") or single
/// ones ("manakov[3,1]"). When none is named it collects every family that is cheap.
class InvariantList {
 public:
  struct Entry {
    std::string_view family;
    std::string name;
    long double value;  ///< long double, because powers may not fit into a double
    long double scale;  ///< the number by which a change of the value is divided
  };

  /// The names of `only` must outlive the list. A stop request leaves the list incomplete.
  explicit InvariantList(std::span<const std::string> only, std::stop_token stop = {});

  /// Returns the token that long sums check.
  const std::stop_token& stop() const { return stop_; }

  bool wants(std::string_view family, bool cheap = true) const;

  /// Adds an invariant, unless its value overflows in the scene's units.
  void add(std::string_view family, std::string name, long double value, long double scale);
  /// Adds a family that has a single invariant.
  void add(std::string_view family, long double value, long double scale);

  /// Adds the elements of a matrix, "PQt[i,j]".
  template <class Matrix>
  void add_elements(std::string_view family, const Matrix& A, long double scale) {
    for (long i = 0; i < A.rows(); ++i)
      for (long j = 0; j < A.cols(); ++j) add(family, indexed(family, i, j), A(i, j), scale);
  }
  /// Adds the elements of a skew matrix above its diagonal.
  template <class Matrix>
  void add_skew(std::string_view family, const Matrix& A, long double scale) {
    for (long i = 0; i < A.rows(); ++i)
      for (long j = i + 1; j < A.cols(); ++j) add(family, indexed(family, i, j), A(i, j), scale);
  }
  /// Adds the coefficients of tr L(μ)ᵏ, k = 1, 2, …, with the scale of the largest of each k. The
  /// powers of μ are counted from 0, or from −k if `laurent`.
  void add_coefficients(std::string_view family,
                        const std::vector<std::vector<long double>>& coefficients,
                        bool laurent = false);

  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::unordered_set<std::string_view> only_, families_;
  std::stop_token stop_;
  std::vector<Entry> entries_;
};

}  // namespace stiefel
