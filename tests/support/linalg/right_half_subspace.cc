#include "tests/support/linalg/right_half_subspace.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/dense/decompositions.h"

extern "C" void dgees_(const char* jobvs, const char* sort,
                       int (*select)(const double* re, const double* im), const int* n, double* a,
                       const int* lda, int* sdim, double* wr, double* wi, double* vs,
                       const int* ldvs, double* work, const int* lwork, int* bwork, int* info);

namespace stiefel::testing {

std::optional<Matrix<double>> right_half_subspace(Matrix<double> H) {
  const int n = static_cast<int>(H.rows()), half = n / 2, work_size = 8 * n;
  Matrix<double> Z(n, n);
  std::vector<double> re(n), im(n), work(work_size);
  std::vector<int> selected(n);
  int found = 0, info = 0;
  const auto right_half = [](const double* real, const double*) { return int{*real > 0}; };
  dgees_("V", "S", right_half, &n, H.data(), &n, &found, re.data(), im.data(), Z.data(), &n,
         work.data(), &work_size, selected.data(), &info);
  if (info != 0 || found != half) return std::nullopt;
  // Rounding moves a double eigenvalue on the imaginary axis off it by the square root of the
  // rounding unit.
  double largest = 0;
  for (int k = 0; k < n; ++k) largest = std::max(largest, std::hypot(re[k], im[k]));
  for (const double x : re)
    if (std::abs(x) <= 1e-7 * largest) return std::nullopt;
  const Matrix<double> top = Z.topLeftCorner(half, half), bottom = Z.bottomLeftCorner(half, half);
  return Lu<double>(top.transpose()).solve(bottom.transpose()).transpose();
}

}  // namespace stiefel::testing
