#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/numbers/pack.h"

namespace stiefel {

/// Two numbers that go through the same operations, in one vector register of the baseline. Every
/// operation gives each of them the bits that it has alone.
using Pair = Pack<double, Isa::baseline, 2>;

/// LU factors of a small dense matrix with pivoting by rows, for right-hand sides in pairs.
class PairLu {
 public:
  explicit PairLu(std::size_t size) : size_(size), A_(size * size), inverse_(size), pivots_(size) {}

  /// The matrix that `factor` takes, and overwrites.
  double& operator()(std::size_t i, std::size_t j) { return A_[i + j * size_]; }
  void set_zero() { std::fill(A_.begin(), A_.end(), 0.0); }

  void factor() {
    for (std::size_t k = 0; k < size_; ++k) {
      double* column = &A_[k * size_];
      std::size_t pivot = k;
      for (std::size_t i = k + 1; i < size_; ++i)
        if (std::abs(column[i]) > std::abs(column[pivot])) pivot = i;
      pivots_[k] = pivot;
      if (pivot != k)
        for (std::size_t j = 0; j < size_; ++j) std::swap(A_[k + j * size_], A_[pivot + j * size_]);
      inverse_[k] = 1 / column[k];
      for (std::size_t i = k + 1; i < size_; ++i) column[i] *= inverse_[k];
      for (std::size_t j = k + 1; j < size_; ++j) {
        double* other = &A_[j * size_];
        const double factor = other[k];
        for (std::size_t i = k + 1; i < size_; ++i) other[i] -= factor * column[i];
      }
    }
  }

  /// Not inlined: g++ 12 takes the loops for longer than a caller's array.
  [[gnu::noinline]] void solve(Pair* x) const {
    for (std::size_t k = 0; k < size_; ++k) std::swap(x[k], x[pivots_[k]]);
    for (std::size_t k = 0; k < size_; ++k) {
      const double* column = &A_[k * size_];
      const Pair x_k = x[k];
      for (std::size_t i = k + 1; i < size_; ++i) x[i] -= Pair(column[i]) * x_k;
    }
    for (std::size_t k = size_; k-- > 0;) {
      const double* column = &A_[k * size_];
      const Pair x_k = x[k] *= Pair(inverse_[k]);
      for (std::size_t i = 0; i < k; ++i) x[i] -= Pair(column[i]) * x_k;
    }
  }

 private:
  std::size_t size_;
  std::vector<double> A_, inverse_;
  std::vector<std::size_t> pivots_;
};

}  // namespace stiefel
