#include "engine/numbers/parallel.h"
#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"

namespace stiefel {
namespace {

template <Into into, class Out, class Product>
[[gnu::always_inline]] inline void write(Out&& out, const Product& product) {
  if constexpr (into == Into::set) out = product;
  if constexpr (into == Into::add) out += product;
  if constexpr (into == Into::subtract) out -= product;
}

/// AB for B of N × N and A and `out` of a multiple of N rows, with the sums of Eigen but for the
/// signs of zeros. All sizes of a block are constants: a product of 3 × 3 takes fewer instructions
/// than Eigen's, whose sizes are known at run time alone.
template <Into into, int N, int left, int right>
void square_product(Strided<double, Eigen::ColMajor>& out, const Strided<const double, left>& A,
                    const Strided<const double, right>& B) {
  constexpr bool of_contiguous = left == Eigen::RowMajor && right == Eigen::ColMajor;
  for (Eigen::Index block = 0; block < out.rows(); block += N)
    for (Eigen::Index j = 0; j < N; ++j) {
      double sums[N];
      for (Eigen::Index i = 0; i < N; ++i) {
        const auto term = [&](Eigen::Index l) { return A.coeff(block + i, l) * B.coeff(l, j); };
        if constexpr (of_contiguous && N >= 4) {
          double even = term(0) + term(2), odd = term(1) + term(3);
          if (N == 6) even += term(4), odd += term(5);
          sums[i] = even + odd;
          if (N == 5) sums[i] += term(4);
        } else {
          sums[i] = term(0);
          for (Eigen::Index l = 1; l < N; ++l) sums[i] += term(l);
        }
      }
      for (Eigen::Index i = 0; i < N; ++i) write<into>(out.coeffRef(block + i, j), sums[i]);
    }
}

/// A rough time of an operation, a multiplication with its addition, of a product of large
/// matrices.
template <class Scalar>
constexpr double operation_nanoseconds = std::is_same_v<Scalar, double> ? 0.13 : 1;

/// AB by Eigen's kernels for large matrices. They sum every element over the same terms in the same
/// order whatever the number of columns, as long as a block begins at a multiple of 4 columns and
/// is not a vector.
template <Into into, class Scalar, int left, int right>
void large_product(Strided<Scalar, Eigen::ColMajor>& out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha) {
  using Product =
      Eigen::internal::generic_product_impl<Strided<const Scalar, left>,
                                            Strided<const Scalar, right>, Eigen::DenseShape,
                                            Eigen::DenseShape, Eigen::GemmProduct>;
  const auto multiply = [&](Index begin, Index end) {
    const auto columns = [&]<class M>(M& all) {
      return M(all.data() + begin * all.colStride(), all.rows(), end - begin,
               Eigen::OuterStride<>(all.outerStride()));
    };
    auto some = columns(out);
    if (into == Into::set && some.outerStride() == some.rows())
      Eigen::Map<Vector<Scalar>>(some.data(), some.size()).setZero();
    else if (into == Into::set)
      some.setZero();
    Product::scaleAndAddTo(some, A, columns(B), into == Into::subtract ? -alpha : alpha);
  };
  const double operations = static_cast<double>(A.size()) * static_cast<double>(B.cols());
  in_wide_ranges(out.cols(), operations * operation_nanoseconds<Scalar>, multiply);
}

/// AB in quadruple precision, with a stop point before every column: at N = 512 a product takes
/// seconds.
template <Into into, int left, int right>
void slow_product(Strided<Quad, Eigen::ColMajor>& out, const Strided<const Quad, left>& A,
                  const Strided<const Quad, right>& B, Quad alpha) {
  for (Eigen::Index j = 0; j < out.cols(); ++j) {
    stop_point();
    write<into>(out.col(j).noalias(), alpha * A.lazyProduct(B.col(j)));
  }
}

/// AB for sizes that Eigen multiplies element by element.
template <Into into, class Scalar, int left, int right>
void small_product(Strided<Scalar, Eigen::ColMajor>& out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha) {
  if constexpr (std::is_same_v<Scalar, double>) {
    const auto square = [&](Eigen::Index N) {
      return alpha == 1 && A.cols() == N && B.cols() == N && A.rows() % N == 0;
    };
    if (square(3)) return square_product<into, 3, left, right>(out, A, B);
    if (square(4)) return square_product<into, 4, left, right>(out, A, B);
    if (square(5)) return square_product<into, 5, left, right>(out, A, B);
    if (square(6)) return square_product<into, 6, left, right>(out, A, B);
  }
  write<into>(out.noalias(), alpha * A.lazyProduct(B));
}

}  // namespace

template <Into into, class Scalar, int left, int right>
void dense_product(Strided<Scalar, Eigen::ColMajor> out, const Strided<const Scalar, left>& A,
                   const Strided<const Scalar, right>& B, Scalar alpha) {
  if constexpr (std::is_same_v<Scalar, Quad>)
    slow_product<into, left, right>(out, A, B, alpha);
  else if (out.rows() + A.cols() + out.cols() >= EIGEN_GEMM_TO_COEFFBASED_THRESHOLD ||
           A.cols() == 0)
    large_product<into, Scalar, left, right>(out, A, B, alpha);
  else
    small_product<into, Scalar, left, right>(out, A, B, alpha);
}

void upper_gram(const Eigen::MatrixXd& A, Eigen::MatrixXd& out) {
  constexpr Index width = 48, least_width = 24, unit = 12;
  const Index N = A.cols();
  Crew* const crew = N < least_divided_order ? nullptr : crew_to_divide();
  const auto threads = crew ? static_cast<Index>(crew->threads_at_hand()) : 1;
  Index blocks = threads > 1 ? (N + width - 1) / width : 1;
  // at least two tiles a thread, unless they would be too small
  while (threads > 1 && blocks * blocks < 4 * threads && (blocks + 1) * least_width <= N) ++blocks;
  const auto edge = [&](Index block) {
    return block == blocks ? N : N / unit * block / blocks * unit;
  };
  const auto tile = [&](Index i, Index j) {
    const Index rows = edge(i + 1) - edge(i), columns = edge(j + 1) - edge(j);
    const auto some = A.middleCols(edge(j), columns);
    auto part = out.block(edge(i), edge(j), rows, columns);
    if (i < j) {
      part.noalias() = A.middleCols(edge(i), rows).transpose() * some;
    } else {
      part.triangularView<Eigen::Upper>().setZero();
      part.selfadjointView<Eigen::Upper>().rankUpdate(some.transpose());
    }
  };
  if (blocks == 1) return tile(0, 0);
  const double operations = static_cast<double>(A.size()) * static_cast<double>(N) / 2;
  const Index pairs = blocks * (blocks - 1) / 2;  // i < j; the triangles take half as long
  share_out(*crew, static_cast<std::size_t>(pairs + blocks),
            operations * operation_nanoseconds<double>, [&](std::size_t k) {
              Index i = static_cast<Index>(k), j = 1;
              if (i >= pairs) return tile(i - pairs, i - pairs);
              while (i >= j) i -= j++;
              tile(i, j);
            });
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

STIEFEL_DENSE_PRODUCTS_OF(double)
STIEFEL_DENSE_PRODUCTS_OF(long double)
STIEFEL_DENSE_PRODUCTS_OF(Quad)

}  // namespace stiefel

STIEFEL_EIGEN_GEMVS(, double)
STIEFEL_EIGEN_GEMVS(, long double)
