#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/numbers/parallel.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// Computes (X + ε)ᵀ(X + ε) to nearly twice the working precision by products in working precision;
/// ε is below the rounding of X (Ozaki et al. 2012). X = H + L, where each column of H is rounded
/// to so few bits that HᵀH is exact, and the rest is YᵀZ + ZᵀY with Y = H + ½L, Z = L + ε. The
/// result is `high`, of which only the upper triangle is set, plus `low` plus the transpose of
/// `low`.
class SplitProduct {
 public:
  explicit SplitProduct(Eigen::Index N) : H_(N, N), L_(N, N) {
    const int carries =
        static_cast<int>(std::ceil(std::log2(std::max(1.0, static_cast<double>(N)))));
    kept_ = (digits - carries) / 2;
  }

  void operator()(const Eigen::MatrixXd& X, const Eigen::MatrixXd& epsilon, Eigen::MatrixXd& high,
                  Eigen::MatrixXd& low) {
    const double of_column = static_cast<double>(X.rows());
    in_column_ranges(X.cols(), of_column, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index j = begin; j < end; ++j) {
        const double largest = X.col(j).cwiseAbs().maxCoeff();
        const double unit =
            largest > 0 ? 1.5 * two_to<double>(std::ilogb(largest) + digits - kept_) : 0;
        for (Eigen::Index i = 0; i < X.rows(); ++i) {
          const double lifted = X(i, j) + unit;
          H_(i, j) = lifted - unit;
          L_(i, j) = X(i, j) - H_(i, j);
        }
      }
    });
    upper_gram(H_, high);
    in_column_ranges(X.cols(), of_column, [&](Eigen::Index begin, Eigen::Index end) {
      const Eigen::Index count = end - begin;
      H_.middleCols(begin, count) += L_.middleCols(begin, count) / 2;
      L_.middleCols(begin, count) += epsilon.middleCols(begin, count);
    });
    low.noalias() = H_.transpose() * L_;
  }

 private:
  static constexpr int digits = std::numeric_limits<double>::digits;

  int kept_;
  Eigen::MatrixXd H_, L_;
};

}  // namespace stiefel
