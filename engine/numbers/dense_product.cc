#include "engine/numbers/scalar.h"

namespace stiefel {

template <Into into, class Scalar, int left, int right>
void dense_product(Strided<Scalar, Eigen::ColMajor> out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha) {
  if constexpr (into == Into::set) {
    // Where Eigen would clear `out` column by column and add to it, all of it is cleared at once.
    const Eigen::Index sizes = out.rows() + A.cols() + out.cols();
    if (sizes >= EIGEN_GEMM_TO_COEFFBASED_THRESHOLD && out.outerStride() == out.rows()) {
      Eigen::Map<Vector<Scalar>>(out.data(), out.size()).setZero();
      return dense_product<Into::add, Scalar, left, right>(out, A, B, alpha);
    }
  }
  const auto write = [&](const auto& product) {
    if constexpr (into == Into::set) out.noalias() = product;
    if constexpr (into == Into::add) out.noalias() += product;
    if constexpr (into == Into::subtract) out.noalias() -= product;
  };
  if (alpha == 1)
    write(A * B);
  else
    write(alpha * A * B);
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
