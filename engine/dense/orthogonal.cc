#include "engine/dense/orthogonal.h"

namespace stiefel {

Matrix<double> repaired(const Matrix<double>& Q) {
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  return orthogonality_defect(Q) > rounding ? nearest_orthogonal<double>(Q) : Q;
}

template Matrix<double> nearest_orthogonal(Matrix<double> Q);

}  // namespace stiefel
