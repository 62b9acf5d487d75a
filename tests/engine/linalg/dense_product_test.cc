#include "engine/numbers/dense_product.h"

#include <gtest/gtest.h>

#include <random>

#include "engine/numbers/scalar.h"

namespace stiefel {
namespace {

template <class Scalar>
class DenseProduct : public ::testing::Test {
 protected:
  using Plain = Matrix<Scalar>;
  using PlainRows = Eigen::Matrix<Scalar, -1, -1, Eigen::RowMajor>;

  Plain random(Eigen::Index rows, Eigen::Index columns) {
    return Plain::NullaryExpr(rows, columns, [&] { return Scalar(uniform_(engine_)); });
  }

  /// The product summed in extended precision, element by element.
  static Plain expected(const Plain& A, const Plain& B) {
    using Wide = long double;
    Plain C(A.rows(), B.cols());
    for (Eigen::Index i = 0; i < C.rows(); ++i)
      for (Eigen::Index j = 0; j < C.cols(); ++j) {
        Wide sum = 0;
        for (Eigen::Index k = 0; k < A.cols(); ++k) sum += Wide(A(i, k)) * Wide(B(k, j));
        C(i, j) = static_cast<Scalar>(sum);
      }
    return C;
  }

  static void expect_near(const Plain& C, const Plain& exact, Eigen::Index depth) {
    const Scalar bound = Scalar(4 * (depth + 2)) * std::numeric_limits<Scalar>::epsilon();
    EXPECT_LE((C - exact).cwiseAbs().maxCoeff(), bound);
  }

 private:
  std::mt19937 engine_{1};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

using Scalars = ::testing::Types<double, long double>;
TYPED_TEST_SUITE(DenseProduct, Scalars);

/// Sizes below and above those from which Eigen uses its blocked kernels, and vectors.
constexpr int sizes[][3] = {{1, 1, 1}, {1, 30, 1},  {30, 1, 30}, {2, 3, 5},    {7, 6, 6},
                            {8, 8, 8}, {1, 40, 33}, {33, 40, 1}, {37, 29, 41}, {120, 70, 90}};

TYPED_TEST(DenseProduct, OperandsOfEachOrder) {
  for (const auto& [rows, depth, columns] : sizes) {
    const auto A = this->random(rows, depth), B = this->random(depth, columns);
    const typename TestFixture::Plain At = A.transpose(), Bt = B.transpose();
    const typename TestFixture::PlainRows Ar = A, Br = B;
    const auto exact = this->expected(A, B);
    this->expect_near(A * B, exact, depth);
    this->expect_near(At.transpose() * B, exact, depth);
    this->expect_near(A * Bt.transpose(), exact, depth);
    this->expect_near(At.transpose() * Bt.transpose(), exact, depth);
    this->expect_near(Ar * B, exact, depth);
    this->expect_near(A * Br, exact, depth);
    typename TestFixture::PlainRows Cr = Ar * Br;
    this->expect_near(Cr, exact, depth);
    Cr.noalias() = At.transpose() * Br;
    this->expect_near(Cr, exact, depth);
  }
}

TYPED_TEST(DenseProduct, SumsMultiplesBlocksAndAliases) {
  using Dense = typename TestFixture::Plain;
  for (const auto& [rows, depth, columns] : sizes) {
    const Dense A = this->random(rows, depth), B = this->random(depth, columns),
                C = this->random(rows, columns);
    const Dense AB = this->expected(A, B);
    Dense out = C;
    out.noalias() += A * B;
    this->expect_near(out, C + AB, depth);
    out = C;
    out.noalias() -= TypeParam(2) * A * B;
    this->expect_near(out, C - TypeParam(2) * AB, 2 * depth);
    out = C;
    out += -A * (B * TypeParam(3));
    this->expect_near(out, C - TypeParam(3) * AB, 3 * depth);

    Dense large = Dense::Constant(rows + 3, columns + 2, TypeParam(7));
    Dense around(depth + 1, columns + 4);
    around.setConstant(std::numeric_limits<TypeParam>::quiet_NaN());
    around.block(1, 2, depth, columns) = B;
    large.block(2, 1, rows, columns).noalias() = A * around.block(1, 2, depth, columns);
    this->expect_near(large.block(2, 1, rows, columns), AB, depth);
    EXPECT_EQ(large(0, 0), TypeParam(7));
    EXPECT_EQ(large(rows + 2, columns + 1), TypeParam(7));
    large.block(2, 1, rows, columns).transpose().noalias() += B.transpose() * A.transpose();
    this->expect_near(large.block(2, 1, rows, columns), 2 * AB, 2 * depth);

    Dense square = this->random(depth, depth);
    const Dense twice = this->expected(square, square);
    square = square * square;
    this->expect_near(square, twice, depth);
  }
}

/// No terms, no rows, no columns.
TYPED_TEST(DenseProduct, EmptyOperands) {
  using Dense = typename TestFixture::Plain;
  const Dense C = Dense(3, 0) * Dense(0, 4);
  EXPECT_EQ(C.rows(), 3);
  EXPECT_EQ(C.cols(), 4);
  EXPECT_TRUE((C.array() == TypeParam(0)).all());
  EXPECT_EQ((Dense(0, 5) * Dense(5, 2)).eval().size(), 0);
}

/// The one that is compiled once gives the bits of Eigen's own product of the same memory.
TYPED_TEST(DenseProduct, HasTheBitsOfEigen) {
  using Dense = typename TestFixture::Plain;
  for (const auto& [rows, depth, columns] : sizes) {
    const Dense At = this->random(depth, rows), B = this->random(depth, columns);
    const Strided<const TypeParam, Eigen::RowMajor> left(At.data(), rows, depth,
                                                         Eigen::OuterStride<>(depth));
    const Strided<const TypeParam, Eigen::ColMajor> right(B.data(), depth, columns,
                                                          Eigen::OuterStride<>(depth));
    EXPECT_EQ(Dense(At.transpose() * B), Dense(left * right));
  }
}

/// Writes AB into a copy of C by dense_product and by Eigen, from the row `at` of a larger matrix
/// on, and returns whether all numbers agree.
template <Into into, int left, int right>
bool small_product_is_that_of_eigen(const Matrix<double>& A, const Matrix<double>& B,
                                    const Matrix<double>& C, Eigen::Index at) {
  const auto place = [&](Matrix<double>& all) { return all.block(at, 0, A.rows(), B.cols()); };
  const Eigen::Matrix<double, -1, -1, left> a = A;
  const Eigen::Matrix<double, -1, -1, right> b = B;
  const Strided<const double, left> a_map(a.data(), a.rows(), a.cols(),
                                          Eigen::OuterStride<>(a.outerStride()));
  const Strided<const double, right> b_map(b.data(), b.rows(), b.cols(),
                                           Eigen::OuterStride<>(b.outerStride()));
  Matrix<double> ours = C, theirs = C;
  auto out = place(ours);
  dense_product<into, double, left, right>(
      Strided<double, Eigen::ColMajor>(out.data(), out.rows(), out.cols(),
                                       Eigen::OuterStride<>(ours.rows())),
      a_map, b_map, 1);
  auto of_eigen = place(theirs);
  if constexpr (into == Into::set) of_eigen.noalias() = a_map.lazyProduct(b_map);
  if constexpr (into == Into::add) of_eigen.noalias() += a_map.lazyProduct(b_map);
  if constexpr (into == Into::subtract) of_eigen.noalias() -= a_map.lazyProduct(b_map);
  return ours == theirs;
}

/// Every size that Eigen leaves to its products of small matrices, columns of `out` that begin at a
/// multiple of 16 bytes and between, and factors with zeros of both signs.
TEST(SmallProduct, HasTheBitsOfEigenButForTheSignsOfZeros) {
  std::mt19937 engine(1);
  const auto random = [&](Eigen::Index rows, Eigen::Index columns) {
    return Matrix<double>::NullaryExpr(rows, columns, [&] {
      const unsigned draw = engine();
      if (draw % 4 == 0) return draw % 8 == 0 ? 0.0 : -0.0;
      return std::uniform_real_distribution<double>(-1, 1)(engine);
    });
  };
  const auto check = [&]<int left, int right>(const auto& A, const auto& B, const auto& C,
                                              Eigen::Index at) {
    using enum Into;
    return small_product_is_that_of_eigen<set, left, right>(A, B, C, at) &&
           small_product_is_that_of_eigen<add, left, right>(A, B, C, at) &&
           small_product_is_that_of_eigen<subtract, left, right>(A, B, C, at);
  };
  constexpr int threshold = EIGEN_GEMM_TO_COEFFBASED_THRESHOLD;
  for (int rows = 1; rows < threshold; ++rows)
    for (int depth = 1; rows + depth < threshold; ++depth)
      for (int columns = 1; rows + depth + columns < threshold; ++columns) {
        const Matrix<double> A = random(rows, depth), B = random(depth, columns);
        for (const int at : {0, 1}) {
          SCOPED_TRACE(::testing::Message() << rows << " x " << depth << " x " << columns);
          const Matrix<double> C = random(rows + 2 + at, columns);
          EXPECT_TRUE((check.template operator()<0, 0>(A, B, C, at)));
          EXPECT_TRUE((check.template operator()<0, 1>(A, B, C, at)));
          EXPECT_TRUE((check.template operator()<1, 0>(A, B, C, at)));
          EXPECT_TRUE((check.template operator()<1, 1>(A, B, C, at)));
        }
      }
}

}  // namespace
}  // namespace stiefel
