#pragma once

#include <array>

#include "engine/linalg/scalar.h"

namespace stiefel {

/// The solutions of the last steps, from which the next one is extrapolated: a cubic through four
/// equidistant ones, less while there are fewer. Part of the state, because it decides bits.
template <class Scalar>
class History {
 public:
  explicit History(Eigen::Index N) : History(N, N) {}
  History(Eigen::Index rows, Eigen::Index cols) : count_(Matrix<Scalar>::Zero(1, 1)) {
    past_.fill(Matrix<Scalar>::Zero(rows, cols));
  }

  /// False when there is nothing to extrapolate from.
  bool predict(Matrix<Scalar>& next) const {
    switch (static_cast<int>(count_(0, 0))) {
      case 0:
        return false;
      case 1:
        next = past_[0];
        break;
      case 2:
        next = 2 * past_[0] - past_[1];
        break;
      case 3:
        next = 3 * (past_[0] - past_[1]) + past_[2];
        break;
      default:
        next = 4 * (past_[0] + past_[2]) - 6 * past_[1] - past_[3];
    }
    return true;
  }

  void push(const Matrix<Scalar>& solution) {
    for (std::size_t k = past_.size() - 1; k > 0; --k) past_[k].swap(past_[k - 1]);
    past_[0] = solution;
    if (count_(0, 0) < static_cast<Scalar>(past_.size())) count_(0, 0) += 1;
  }

  template <class Visitor>
  void each(Visitor&& visit) {
    visit(count_);
    for (auto& block : past_) visit(block);
  }

 private:
  Matrix<Scalar> count_;
  std::array<Matrix<Scalar>, 4> past_;
};

}  // namespace stiefel
