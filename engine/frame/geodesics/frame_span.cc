#include <algorithm>

#include "engine/dense/decompositions.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

template <int n>
using Columns = Eigen::Map<const Eigen::Matrix<double, n, Eigen::Dynamic>>;

template <int n>
void add_gram_of(Columns<n> A, Columns<n> B, MatrixXd& out) {
  Eigen::Matrix<double, n, n> sum = Eigen::Matrix<double, n, n>::Zero();
  for (Index j = 0; j < A.cols(); ++j) sum.noalias() += A.col(j) * B.col(j).transpose();
  out += sum;
}

template <int n>
void combine_of(const MatrixXd& C, Columns<n> A, const MatrixXd& D, Columns<n> B, MatrixXd& out) {
  const Eigen::Matrix<double, n, n> left = C, right = D;
  for (Index j = 0; j < A.cols(); ++j) {
    Eigen::Matrix<double, n, 1> column = left * A.col(j);
    column.noalias() += right * B.col(j);
    Eigen::Map<Eigen::Matrix<double, n, 1>>(out.data() + n * j) = column;
  }
}

/// Calls `use` with n as a constant where it is small and N is large: loops over columns of a known
/// size are then faster than Eigen's products. Returns whether it did.
template <class Use>
bool with_few_rows(Index n, Index N, const Use& use) {
  if (N < 64) return false;
  switch (n) {
    case 2:
      return use(std::integral_constant<int, 2>()), true;
    case 3:
      return use(std::integral_constant<int, 3>()), true;
    case 4:
      return use(std::integral_constant<int, 4>()), true;
    case 5:
      return use(std::integral_constant<int, 5>()), true;
    case 6:
      return use(std::integral_constant<int, 6>()), true;
  }
  return false;
}

/// Calls `use(from, columns)` for pieces of N columns that fit into the nearest cache. Sums of
/// pieces also keep the rounding of a long sum small.
template <class Use>
void by_pieces(Index N, const Use& use) {
  constexpr Index piece = 256;
  for (Index from = 0; from < N; from += piece) use(from, std::min(piece, N - from));
}

void add_gram(const MatrixXd& A, const MatrixXd& B, Index from, Index columns, MatrixXd& out) {
  const Index n = A.rows();
  if (!with_few_rows(n, columns, [&](auto few) {
        add_gram_of<few>({A.data() + n * from, n, columns}, {B.data() + n * from, n, columns}, out);
      }))
    out.noalias() += A.middleCols(from, columns) * B.middleCols(from, columns).transpose();
}

MatrixXd gram(const MatrixXd& A, const MatrixXd& B) {
  MatrixXd out = MatrixXd::Zero(A.rows(), B.rows());
  by_pieces(A.cols(), [&](Index from, Index columns) { add_gram(A, B, from, columns, out); });
  return out;
}

/// Returns CA + DB.
MatrixXd combined(const MatrixXd& C, const MatrixXd& A, const MatrixXd& D, const MatrixXd& B) {
  const Index n = C.rows(), N = A.cols();
  MatrixXd out(n, N);
  if (A.rows() == n && B.rows() == n && with_few_rows(n, N, [&](auto few) {
        combine_of<few>(C, {A.data(), n, N}, D, {B.data(), n, N}, out);
      }))
    return out;
  out.noalias() = C * A;
  out.noalias() += D * B;
  return out;
}

}  // namespace

FrameProducts frame_products(const MatrixXd& Q_0, const MatrixXd& Q_T) {
  const MatrixXd zero = MatrixXd::Zero(Q_0.rows(), Q_0.rows());
  FrameProducts out{zero, zero, zero};
  by_pieces(Q_0.cols(), [&](Index from, Index columns) {
    add_gram(Q_0, Q_0, from, columns, out.of_Q_0);
    add_gram(Q_T, Q_T, from, columns, out.of_Q_T);
    add_gram(Q_T, Q_0, from, columns, out.mixed);
  });
  return out;
}

FrameSpan::FrameSpan(const MatrixXd& Q_0, const MatrixXd& Q_T, const FrameProducts& products)
    : Q_0_(Q_0), Q_T_(Q_T), C_(products.mixed), n_(Q_0.rows()), p_(std::min(n_, Q_0.cols() - n_)) {
  stop_point(2 * connect_work::frame(n_, Q_0.cols()));
  target_.resize(n_ + p_, n_);
  target_.topRows(n_) = C_.transpose();
  if (p_ == n_ && (is_implied(products) || is_orthonormalised())) return;
  MatrixXd both(Q_0.cols(), 2 * n_);
  both << Q_0.transpose(), (Q_T - C_ * Q_0).transpose();
  K_ = orthonormal_columns(both, n_ + p_).rightCols(p_).transpose();
  to_K_ = MatrixXd::Identity(p_, p_);
  target_.bottomRows(p_).noalias() = K_ * Q_T.transpose();
}

MatrixXd FrameSpan::lifted(const MatrixXd& X) const {
  const MatrixXd A = X.topRows(n_).transpose(), B = X.bottomRows(p_).transpose() * to_K_;
  return K_.size() > 0 ? combined(A, Q_0_, B, K_) : combined(A - B * C_, Q_0_, B, Q_T_);
}

FrameSpan::Squares FrameSpan::factor(const MatrixXd& products, MatrixXd& whole) {
  MatrixXd L = products;
  if (!factor_positive(L)) return {0, 0};
  L.triangularView<Eigen::StrictlyUpper>().setZero();
  const Eigen::VectorXd squares = L.diagonal().cwiseAbs2();
  to_K_ = MatrixXd::Identity(n_, n_);
  divide_by_lower(L, to_K_);
  whole = (whole * L).eval();
  target_.bottomRows(n_) = whole.transpose();
  return {squares.minCoeff(), squares.minCoeff() / squares.maxCoeff()};
}

bool FrameSpan::is_implied(const FrameProducts& products) {
  constexpr double good = 0.02;
  MatrixXd whole = MatrixXd::Identity(n_, n_);
  const MatrixXd of_C = C_ * C_.transpose();
  const auto [least, ratio] =
      factor(products.of_Q_T - 2 * of_C + C_ * products.of_Q_0 * C_.transpose(), whole);
  return least > good && ratio > good;
}

bool FrameSpan::is_orthonormalised() {
  constexpr double least_ratio = 1e-9;
  MatrixXd whole = MatrixXd::Identity(n_, n_);
  K_ = Q_T_;
  K_.noalias() -= C_ * Q_0_;
  for (int pass = 0; pass < 2; ++pass) {
    if (pass > 0) K_ = combined(to_K_, K_, -to_K_ * gram(K_, Q_0_), Q_0_);
    if (!(factor(gram(K_, K_), whole).ratio > least_ratio)) return false;
  }
  return true;
}

}  // namespace stiefel
