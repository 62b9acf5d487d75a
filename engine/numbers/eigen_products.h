#pragma once

#include <Eigen/Core>
#include <complex>

#include "stiefel/stop.h"

namespace stiefel {

/// Whether products of dense matrices of a Scalar are computed element by element. Eigen's kernels
/// for large matrices have no packets of our number types, and would be compiled again for each
/// form of an expression.
template <class Scalar>
inline constexpr bool multiplied_by_elements = false;
template <>
inline constexpr bool multiplied_by_elements<std::complex<long double>> = true;

}  // namespace stiefel

template <class Left, class Right>
requires stiefel::multiplied_by_elements<typename Left::Scalar>
struct Eigen::internal::product_type<Left, Right> {
  static constexpr bool inner = Left::RowsAtCompileTime == 1 && Right::ColsAtCompileTime == 1;
  enum { value = inner ? InnerProduct : CoeffBasedProductMode, ret = value };
};

/// Products element by element, with a check for a stop request before each column: at N = 512 one
/// product takes seconds.
template <class Left, class Right>
requires(
    stiefel::multiplied_by_elements<typename Left::Scalar>&& Left::RowsAtCompileTime ==
        Eigen::Dynamic &&
    Right::ColsAtCompileTime ==
        Eigen::Dynamic) struct Eigen::internal::generic_product_impl<Left, Right, Eigen::DenseShape,
                                                                     Eigen::DenseShape,
                                                                     Eigen::CoeffBasedProductMode> {
  template <class Out>
  static void evalTo(Out& out, const Left& A, const Right& B) {
    by_columns(A, B, [&](Eigen::Index j, const auto& column) { out.col(j).noalias() = column; });
  }
  template <class Out>
  static void addTo(Out& out, const Left& A, const Right& B) {
    by_columns(A, B, [&](Eigen::Index j, const auto& column) { out.col(j).noalias() += column; });
  }
  template <class Out>
  static void subTo(Out& out, const Left& A, const Right& B) {
    by_columns(A, B, [&](Eigen::Index j, const auto& column) { out.col(j).noalias() -= column; });
  }

 private:
  template <class Take>
  static void by_columns(const Left& A, const Right& B, const Take& take) {
    const typename Eigen::internal::nested_eval<Left, Eigen::Dynamic>::type left(A);
    const typename Eigen::internal::nested_eval<Right, Eigen::Dynamic>::type right(B);
    for (Eigen::Index j = 0; j < right.cols(); ++j) {
      stiefel::stop_point();
      take(j, left.lazyProduct(right.col(j)));
    }
  }
};

/// Declares explicit instantiations of Eigen's kernels for products of dense matrices of a Scalar.
/// eigen_products.cc compiles them once, in place of every file that multiplies. The template
/// arguments are those that Eigen's traits give for the machine.
#define STIEFEL_EIGEN_PRODUCTS(EXTERN, Scalar)                                                   \
  namespace Eigen::internal {                                                                    \
  EXTERN template struct gebp_kernel<                                                            \
      Scalar, Scalar, Index, blas_data_mapper<Scalar, Index, ColMajor>,                          \
      gebp_traits<Scalar, Scalar>::mr, gebp_traits<Scalar, Scalar>::nr>;                         \
  STIEFEL_EIGEN_PACK_LHS(EXTERN, Scalar, ColMajor)                                               \
  STIEFEL_EIGEN_PACK_LHS(EXTERN, Scalar, RowMajor)                                               \
  EXTERN template struct gemm_pack_rhs<Scalar, Index,                                            \
                                       const_blas_data_mapper<Scalar, Index, ColMajor>,          \
                                       gebp_traits<Scalar, Scalar>::nr, ColMajor>;               \
  EXTERN template struct gemm_pack_rhs<Scalar, Index,                                            \
                                       const_blas_data_mapper<Scalar, Index, RowMajor>,          \
                                       gebp_traits<Scalar, Scalar>::nr, RowMajor>;               \
  EXTERN template struct gemm_pack_rhs<Scalar, Index, blas_data_mapper<Scalar, Index, ColMajor>, \
                                       gebp_traits<Scalar, Scalar>::nr, ColMajor, false, true>;  \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, ColMajor, ColMajor)                                         \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, ColMajor, RowMajor)                                         \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, RowMajor, ColMajor)                                         \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, RowMajor, RowMajor)                                         \
  STIEFEL_EIGEN_GEMM(EXTERN, Scalar, ColMajor, ColMajor)                                         \
  STIEFEL_EIGEN_GEMM(EXTERN, Scalar, ColMajor, RowMajor)                                         \
  STIEFEL_EIGEN_GEMM(EXTERN, Scalar, RowMajor, ColMajor)                                         \
  STIEFEL_EIGEN_GEMM(EXTERN, Scalar, RowMajor, RowMajor)                                         \
  EXTERN template void evaluateProductBlockingSizesHeuristic<Scalar, Scalar, 1>(Index&, Index&,  \
                                                                                Index&, Index);  \
  EXTERN template void evaluateProductBlockingSizesHeuristic<Scalar, Scalar, 4>(Index&, Index&,  \
                                                                                Index&, Index);  \
  }

#define STIEFEL_EIGEN_PACK_LHS(EXTERN, Scalar, order)                            \
  EXTERN template struct gemm_pack_lhs<                                          \
      Scalar, Index, const_blas_data_mapper<Scalar, Index, order>,               \
      gebp_traits<Scalar, Scalar>::mr, gebp_traits<Scalar, Scalar>::LhsProgress, \
      gebp_traits<Scalar, Scalar>::LhsPacket4Packing, order>;

#define STIEFEL_EIGEN_GEMV(EXTERN, Scalar, left, right)                                \
  EXTERN template struct general_matrix_vector_product<                                \
      Index, Scalar, const_blas_data_mapper<Scalar, Index, left>, left, false, Scalar, \
      const_blas_data_mapper<Scalar, Index, right>, false>;

#define STIEFEL_EIGEN_GEMM(EXTERN, Scalar, left, right)                                           \
  EXTERN template struct general_matrix_matrix_product<Index, Scalar, left, false, Scalar, right, \
                                                       false, ColMajor, 1>;

STIEFEL_EIGEN_PRODUCTS(extern, float)
STIEFEL_EIGEN_PRODUCTS(extern, double)
STIEFEL_EIGEN_PRODUCTS(extern, long double)
