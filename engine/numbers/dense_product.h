#pragma once

#include <Eigen/Core>
#include <type_traits>

namespace stiefel {

/// What a product does to the matrix that it is written to.
enum class Into { set, add, subtract };

/// A matrix in memory whose columns (Eigen::ColMajor) or rows are a stride apart. A const Scalar
/// makes it read-only.
template <class Scalar, int order>
using Strided =
    Eigen::Map<std::conditional_t<std::is_const_v<Scalar>,
                                  const Eigen::Matrix<std::remove_const_t<Scalar>, -1, -1, order>,
                                  Eigen::Matrix<Scalar, -1, -1, order>>,
               Eigen::Unaligned, Eigen::OuterStride<>>;

/// Computes out = αAB, out + αAB or out − αAB with the bits of Eigen's product, for A m × k, B k ×
/// c and `out` m × c, which overlaps neither. The threads of the crew share the columns of products
/// of large matrices, before each of which is a stop point (stiefel/stop.h). dense_product.cc
/// compiles it for double, long double and Quad and both orders of each operand.
template <Into into, class Scalar, int left, int right>
void dense_product(Strided<Scalar, Eigen::ColMajor> out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha);

/// Sets the elements on and above the diagonal of out = AᵀA. A and `out` must be different
/// matrices. The threads of the crew share the columns of large matrices, with the same bits.
void upper_gram(const Eigen::MatrixXd& A, Eigen::MatrixXd& out);

/// Whether dense_product is compiled for a Scalar.
template <class Scalar>
inline constexpr bool is_multiplied_once =
    std::is_same_v<Scalar, double> || std::is_same_v<Scalar, long double>;

/// A matrix of any size, or an expression of one.
template <class A>
concept DenseOperand = is_multiplied_once<typename A::Scalar> &&
                       (A::MaxRowsAtCompileTime == Eigen::Dynamic) &&
                       (A::MaxColsAtCompileTime == Eigen::Dynamic);

/// Whether an expression is a matrix in memory, a block, transpose or multiple of one.
template <class A>
inline constexpr bool is_in_memory = bool(Eigen::internal::blas_traits<A>::HasUsableDirectAccess);

template <class A>
inline constexpr bool is_strided = false;
template <class M>
inline constexpr bool is_strided<Eigen::Map<M, Eigen::Unaligned, Eigen::OuterStride<>>> = true;

/// Whether every file that multiplies A and B calls the one dense_product, which hands Strided
/// operands to Eigen.
template <class A, class B>
concept MultipliedOnce = std::is_same_v<typename A::Scalar, typename B::Scalar> &&
    DenseOperand<A> && DenseOperand<B> && !(is_strided<A> && is_strided<B>);

/// Calls dense_product on the memory of out, A and B; expressions without memory are evaluated.
template <Into into, class Out, class A, class B>
void multiply(Out& out, const A& a, const B& b) {
  using Scalar = typename Out::Scalar;
  if constexpr (!is_in_memory<A>) {
    multiply<into>(out, typename A::PlainObject(a), b);
  } else if constexpr (!is_in_memory<B>) {
    multiply<into>(out, a, typename B::PlainObject(b));
  } else if constexpr (Out::IsRowMajor) {
    auto turned = out.transpose();
    multiply<into>(turned, b.transpose(), a.transpose());
  } else {
    const auto strided = []<class M>(const M& m) {
      return Strided<const Scalar, M::IsRowMajor>(m.data(), m.rows(), m.cols(),
                                                  Eigen::OuterStride<>(m.outerStride()));
    };
    const auto left = strided(Eigen::internal::blas_traits<A>::extract(a));
    const auto right = strided(Eigen::internal::blas_traits<B>::extract(b));
    static_assert(Eigen::internal::inner_stride_at_compile_time<Out>::ret == 1);
    dense_product<into, Scalar, left.IsRowMajor, right.IsRowMajor>(
        Strided<Scalar, Eigen::ColMajor>(out.data(), out.rows(), out.cols(),
                                         Eigen::OuterStride<>(out.outerStride())),
        left, right, Eigen::internal::combine_scalar_factors<Scalar>(a, b));
  }
}

}  // namespace stiefel

/// Eigen compiles a product anew for each pair of types of operands, half a second each. Those of
/// dense matrices call dense_product instead.
template <class A, class B>
requires stiefel::MultipliedOnce<A, B>
struct Eigen::internal::generic_product_impl<A, B, Eigen::DenseShape, Eigen::DenseShape,
                                             Eigen::GemmProduct> {
  template <class Out>
  static void evalTo(Out& out, const A& a, const B& b) {
    stiefel::multiply<stiefel::Into::set>(out, a, b);
  }
  template <class Out>
  static void addTo(Out& out, const A& a, const B& b) {
    stiefel::multiply<stiefel::Into::add>(out, a, b);
  }
  template <class Out>
  static void subTo(Out& out, const A& a, const B& b) {
    stiefel::multiply<stiefel::Into::subtract>(out, a, b);
  }
};

/// Declares explicit instantiations of Eigen's products of dense matrices of a Scalar with vectors.
/// dense_product.cc compiles them once, in place of every file that multiplies.
#define STIEFEL_EIGEN_GEMV(EXTERN, Scalar, left, right)                                          \
  EXTERN template struct Eigen::internal::general_matrix_vector_product<                         \
      Eigen::Index, Scalar, Eigen::internal::const_blas_data_mapper<Scalar, Eigen::Index, left>, \
      left, false, Scalar, Eigen::internal::const_blas_data_mapper<Scalar, Eigen::Index, right>, \
      false>;
#define STIEFEL_EIGEN_GEMVS(EXTERN, Scalar)                            \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, Eigen::ColMajor, Eigen::ColMajor) \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, Eigen::ColMajor, Eigen::RowMajor) \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, Eigen::RowMajor, Eigen::ColMajor) \
  STIEFEL_EIGEN_GEMV(EXTERN, Scalar, Eigen::RowMajor, Eigen::RowMajor)
STIEFEL_EIGEN_GEMVS(extern, double)
STIEFEL_EIGEN_GEMVS(extern, long double)
