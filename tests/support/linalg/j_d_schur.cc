#include "tests/support/linalg/j_d_schur.h"

#include <cmath>
#include <vector>

#include "engine/dense/decompositions.h"

extern "C" void dgees_(const char* jobvs, const char* sort,
                       int (*select)(const double* re, const double* im), const int* n, double* a,
                       const int* lda, int* sdim, double* wr, double* wi, double* vs,
                       const int* ldvs, double* work, const int* lwork, int* bwork, int* info);

namespace stiefel::testing {

std::optional<Matrix<double>> J_D_inverse_schur(const Vector<double>& lambda,
                                                const Matrix<double>& K) {
  const int N = static_cast<int>(lambda.size()), n = 2 * N, work_size = 16 * n;
  Matrix<double> H(n, n), Z(n, n);
  Matrix<double> square = K * K / 4;
  square.diagonal() += lambda.cwiseAbs2();
  H << K / 2, Matrix<double>::Identity(N, N), square, K / 2;

  std::vector<double> re(n), im(n), work(work_size);
  std::vector<int> selected(n);
  int found = 0, info = 0;
  const auto right_half = [](const double* real, const double*) { return int{*real > 0}; };
  dgees_("V", "S", right_half, &n, H.data(), &n, &found, re.data(), im.data(), Z.data(), &n,
         work.data(), &work_size, selected.data(), &info);
  if (info != 0 || found != N) return std::nullopt;
  // Rounding moves a double eigenvalue on the imaginary axis off it by the square root of the
  // rounding unit.
  constexpr double imaginary = 1e-7;
  for (const double x : re)
    if (std::abs(x) <= imaginary * lambda.maxCoeff()) return std::nullopt;

  const Matrix<double> Z1 = Z.topLeftCorner(N, N).transpose();
  const Matrix<double> Z2 = Z.bottomLeftCorner(N, N).transpose();
  const Matrix<double> S = Z1.partialPivLu().solve(Z2).transpose();  // S = Z2 Z1⁻¹
  return ((S + S.transpose()) / 2 + K / 2) * lambda.cwiseInverse().asDiagonal();
}

}  // namespace stiefel::testing
