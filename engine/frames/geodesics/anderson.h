#pragma once

#include <algorithm>

#include "engine/linalg/matrix_equations/decompositions.h"

namespace stiefel {

/// Anderson's acceleration of the iteration x ← x + f(x): x ← x + f − Σ g_i (Δx_i + Δf_i), where g
/// minimises ‖f − Σ g_i Δf_i‖ over the last `depth` differences.
class Anderson {
 public:
  Anderson(Eigen::Index size, Eigen::Index depth) : steps_(size, depth), changes_(size, depth) {}

  void operator()(Eigen::VectorXd& x, const Eigen::VectorXd& f) {
    if (seen_ > 0) {
      const Eigen::Index column = (seen_ - 1) % steps_.cols();
      steps_.col(column) = x - x_;
      changes_.col(column) = f - f_;
    }
    x_ = x;
    f_ = f;
    x += f;
    if (const Eigen::Index m = std::min(seen_, steps_.cols()); m > 0) {
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(changes_.leftCols(m));
      qr.setThreshold(1e-12);
      const Eigen::VectorXd g = qr.solve(f);
      x.noalias() -= steps_.leftCols(m) * g;
      x.noalias() -= changes_.leftCols(m) * g;
    }
    ++seen_;
  }

 private:
  Eigen::MatrixXd steps_, changes_;
  Eigen::VectorXd x_, f_;
  Eigen::Index seen_ = 0;
};

}  // namespace stiefel
