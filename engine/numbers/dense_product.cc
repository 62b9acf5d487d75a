#include "engine/numbers/scalar.h"

namespace stiefel {
namespace {

using Pair [[gnu::vector_size(16)]] = double;
using UnalignedPair [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;

template <Into into, class Out, class Product>
[[gnu::always_inline]] inline void write(Out&& out, const Product& product) {
  if constexpr (into == Into::set) out = product;
  if constexpr (into == Into::add) out += product;
  if constexpr (into == Into::subtract) out -= product;
}

/// AB for small matrices of which A is stored by columns: Σₗ A(i, l) B(l, j), in the order of l.
/// As in Eigen, two rows are computed together where `out` begins at a multiple of 16 bytes. Their
/// sums begin at 0, the sum of a single row at its first term; this decides the signs of zeros.
template <Into into, int right, int depth>
void by_columns_of_left(Strided<double, Eigen::ColMajor>& out,
                        const Strided<const double, Eigen::ColMajor>& A,
                        const Strided<const double, right>& B) {
  const Eigen::Index m = out.rows(), lda = A.outerStride();
  const Eigen::Index k = depth == Eigen::Dynamic ? A.cols() : depth;
  const Eigen::Index next = right == Eigen::RowMajor ? B.outerStride() : 1;
  const double* const a = A.data();
  for (Eigen::Index j = 0; j < out.cols(); ++j) {
    const double* const b = &B.coeffRef(0, j);
    double* const column = &out.coeffRef(0, j);
    const auto row = [&](Eigen::Index i) {
      double sum = a[i] * b[0];
      for (Eigen::Index l = 1; l < k; ++l) sum += a[i + l * lda] * b[l * next];
      write<into>(column[i], sum);
    };
    Eigen::Index i = Eigen::internal::first_aligned<16>(column, m);
    if (i == 1) row(0);
    for (; i + 2 <= m; i += 2) {
      Pair sum = {};
      for (Eigen::Index l = 0; l < k; ++l)
        sum += *reinterpret_cast<const UnalignedPair*>(a + i + l * lda) * b[l * next];
      write<into>(*reinterpret_cast<Pair*>(column + i), sum);
    }
    if (i < m) row(i);
  }
}

/// AB for small matrices, A stored by rows and B by columns: products of contiguous vectors. As in
/// Eigen, the terms are added to four sums, by l modulo 4; a pair and a term may be left.
template <Into into, int depth>
void by_rows_of_left(Strided<double, Eigen::ColMajor>& out,
                     const Strided<const double, Eigen::RowMajor>& A,
                     const Strided<const double, Eigen::ColMajor>& B) {
  const Eigen::Index k = depth == Eigen::Dynamic ? A.cols() : depth;
  const Eigen::Index of_four = k / 4 * 4, of_two = k / 2 * 2;
  for (Eigen::Index j = 0; j < out.cols(); ++j)
    for (Eigen::Index i = 0; i < out.rows(); ++i) {
      const double* const a = &A.coeffRef(i, 0);
      const double* const b = &B.coeffRef(0, j);
      const auto terms = [&](Eigen::Index l) {
        return *reinterpret_cast<const UnalignedPair*>(a + l) *
               *reinterpret_cast<const UnalignedPair*>(b + l);
      };
      double sum;
      if (k == 1) {
        sum = a[0] * b[0];
      } else {
        Pair pair = terms(0);
        if (of_four > 0) {
          Pair other = terms(2);
          for (Eigen::Index l = 4; l < of_four; l += 4) {
            pair += terms(l);
            other += terms(l + 2);
          }
          pair += other;
          if (of_two > of_four) pair += terms(of_four);
        }
        sum = pair[0] + pair[1];
        if (of_two < k) sum += a[of_two] * b[of_two];
      }
      write<into>(out.coeffRef(i, j), sum);
    }
}

/// AB for matrices that Eigen multiplies element by element, with Eigen's bits. The depths of
/// motions in three and four dimensions are constants: a product of 3 × 3 takes 157 instructions
/// where Eigen's, whose sizes are known at run time alone, takes 277.
template <Into into, int left, int right>
void small_product(Strided<double, Eigen::ColMajor>& out, const Strided<const double, left>& A,
                   const Strided<const double, right>& B) {
  const auto with_depth = [&]<int depth>() {
    if constexpr (left == Eigen::RowMajor)
      by_rows_of_left<into, depth>(out, A, B);
    else
      by_columns_of_left<into, right, depth>(out, A, B);
  };
  if (A.cols() == 3) return with_depth.template operator()<3>();
  if (A.cols() == 4) return with_depth.template operator()<4>();
  with_depth.template operator()<Eigen::Dynamic>();
}

}  // namespace

template <Into into, class Scalar, int left, int right>
void dense_product(Strided<Scalar, Eigen::ColMajor> out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha) {
  using Large =
      Eigen::internal::generic_product_impl<Strided<const Scalar, left>,
                                            Strided<const Scalar, right>, Eigen::DenseShape,
                                            Eigen::DenseShape, Eigen::GemmProduct>;
  if (out.rows() + A.cols() + out.cols() >= EIGEN_GEMM_TO_COEFFBASED_THRESHOLD || A.cols() == 0) {
    if (into == Into::set && out.outerStride() == out.rows())
      Eigen::Map<Vector<Scalar>>(out.data(), out.size()).setZero();
    else if (into == Into::set)
      out.setZero();
    return Large::scaleAndAddTo(out, A, B, into == Into::subtract ? -alpha : alpha);
  }
  if constexpr (std::is_same_v<Scalar, double> && !(left && right))
    if (alpha == 1) return small_product<into, left, right>(out, A, B);
  if (alpha == 1)
    write<into>(out.noalias(), A * B);
  else
    write<into>(out.noalias(), alpha * A * B);
}

#define STIEFEL_DENSE_PRODUCTS(into, Scalar)        \
  STIEFEL_DENSE_PRODUCT(into, Scalar, false, false) \
  STIEFEL_DENSE_PRODUCT(into, Scalar, false, true)  \
  STIEFEL_DENSE_PRODUCT(into, Scalar, true, false)  \
  STIEFEL_DENSE_PRODUCT(into, Scalar, true, true)
#define STIEFEL_DENSE_PRODUCT(into, Scalar, left, right)                    \
  template void dense_product<Into::into, Scalar, left, right>(             \
      Strided<Scalar, Eigen::ColMajor>, const Strided<const Scalar, left>&, \
      const Strided<const Scalar, right>&, Scalar);
#define STIEFEL_DENSE_PRODUCTS_OF(Scalar) \
  STIEFEL_DENSE_PRODUCTS(set, Scalar)     \
  STIEFEL_DENSE_PRODUCTS(add, Scalar)     \
  STIEFEL_DENSE_PRODUCTS(subtract, Scalar)

STIEFEL_DENSE_PRODUCTS_OF(float)
STIEFEL_DENSE_PRODUCTS_OF(double)
STIEFEL_DENSE_PRODUCTS_OF(long double)

}  // namespace stiefel
