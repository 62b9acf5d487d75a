#pragma once

#include <algorithm>
#include <array>

#include "engine/numbers/parallel.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// The solutions of the last steps. A polynomial through the last p ≤ depth of them extrapolates
/// the next one; the size of their differences determines p. The history influences the bits of a
/// solution, so it is part of the state. Does not allocate after construction.
template <class Scalar, int depth>
class History {
 public:
  History(Eigen::Index rows, Eigen::Index cols) : count_(Matrix<Scalar>::Zero(1, 1)) {
    past_.fill(Matrix<Scalar>::Zero(rows, cols));
  }

  /// Sets next = Σ_k (−1)^k C(p, k + 1) past_k, k < p. Returns false when the history predicts no
  /// better than 0.
  template <class Block>
  bool predict(Block& next) const {
    const int p = points();
    if (p == 0) return false;
    const auto predict_range = [&](Eigen::Index begin, Eigen::Index end) {
      Eigen::Map<Vector<Scalar>> sum(next.data() + begin, end - begin);
      Scalar coefficient = Scalar(p);
      sum = coefficient * numbers(0, begin, end - begin);
      for (int k = 1; k < p; ++k) {
        coefficient = -coefficient * Scalar(p - k) / Scalar(k + 1);
        sum += coefficient * numbers(k, begin, end - begin);
      }
    };
    in_ranges(next.size(), 1024, static_cast<double>(p * next.size()), predict_range);
    return true;
  }

  template <class Block>
  void push(const Block& solution) {
    for (std::size_t k = depth - 1; k > 0; --k) past_[k].swap(past_[k - 1]);
    copy_numbers(solution.data(), solution.size(), past_[0].data());
    if (count_(0, 0) < Scalar(depth)) count_(0, 0) += 1;
  }

  template <class Visitor>
  void each(Visitor&& visit) {
    visit(count_);
    for (auto& block : past_) visit(block);
  }

 private:
  Eigen::Map<const Vector<Scalar>> numbers(int k, Eigen::Index start, Eigen::Index length) const {
    return {past_[static_cast<std::size_t>(k)].data() + start, length};
  }

  /// Returns the p with the smallest p-th difference, measured on a sample of the elements: the
  /// error of an extrapolation from p points is about that difference. Returns the number of all
  /// points while the differences still fall.
  int points() const {
    constexpr Eigen::Index most = 16;
    const int count = static_cast<int>(count_(0, 0));
    if (count < 2) return count;
    const Eigen::Index size = past_[0].size(), length = std::min(size, most);
    Eigen::Matrix<Scalar, Eigen::Dynamic, depth, 0, most, depth> difference(length, +depth);
    for (int k = 0; k < count; ++k) difference.col(k) = numbers(k, (size - length) / 2, length);
    Scalar least = difference.col(0).cwiseAbs().maxCoeff();
    int best = 0;
    for (int p = 1; p < count; ++p) {
      const Eigen::Index rest = length * (count - p);  // each column less the next
      Eigen::Map<Vector<Scalar>>(difference.data(), rest) -=
          Eigen::Map<const Vector<Scalar>>(difference.data() + length, rest);
      const Scalar size_of_p = difference.col(0).cwiseAbs().maxCoeff();
      if (!(size_of_p < least)) continue;
      least = size_of_p;
      best = p;
    }
    return best == count - 1 ? count : best;
  }

  Matrix<Scalar> count_;
  std::array<Matrix<Scalar>, depth> past_;
};

}  // namespace stiefel
