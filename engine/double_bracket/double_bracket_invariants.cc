#include "engine/double_bracket/double_bracket_invariants.h"

#include "stiefel/stop.h"

namespace Eigen::internal {

using WorkMatrix = JacobiSVD<stiefel::Matrix<std::complex<double>>>::WorkMatrixType;

/// Repeats Eigen's singular value decomposition of a real block of two rows, operation by
/// operation, with a check for a stop request before it. Eigen's Jacobi method does this once a
/// rotation, whose 24 N operations follow; for 256 x 256 matrices it takes five seconds.
template <>
void real_2x2_jacobi_svd<WorkMatrix, double, Index>(const WorkMatrix& matrix, Index p, Index q,
                                                    JacobiRotation<double>* left,
                                                    JacobiRotation<double>* right) {
  stiefel::stop_point(24 * static_cast<double>(matrix.cols()));
  Matrix<double, 2, 2> m;
  m << numext::real(matrix.coeff(p, p)), numext::real(matrix.coeff(p, q)),
      numext::real(matrix.coeff(q, p)), numext::real(matrix.coeff(q, q));
  JacobiRotation<double> symmetric;
  const double t = m.coeff(0, 0) + m.coeff(1, 1), d = m.coeff(1, 0) - m.coeff(0, 1);
  if (std::abs(d) < std::numeric_limits<double>::min()) {
    symmetric.s() = 0;
    symmetric.c() = 1;
  } else {
    const double u = t / d, length = std::sqrt(1 + numext::abs2(u));
    symmetric.s() = 1 / length;
    symmetric.c() = u / length;
  }
  m.applyOnTheLeft(0, 1, symmetric);
  right->makeJacobi(m, 0, 1);
  *left = symmetric * right->transpose();
}

}  // namespace Eigen::internal

namespace stiefel {

template Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                                        const Matrix<std::complex<double>>& P,
                                        std::complex<double> a, std::complex<double> b);

}  // namespace stiefel
