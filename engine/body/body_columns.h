#pragma once

#include "engine/dense/so_3.h"
#include "engine/numbers/pair.h"
#include "engine/numbers/scalar.h"

namespace stiefel {

/// Tangent vectors of a left-invariant body, (η, δM) with δQ = Qη, by their elements i < j, in
/// pairs. N is the dimension where it is fixed, else Eigen::Dynamic.
template <int N>
class BodyColumns {
 public:
  using Dense = Eigen::MatrixXd;
  using Index = Eigen::Index;
  static constexpr int d = N > 0 ? N*(N - 1) / 2 : Eigen::Dynamic;

  /// Returns the number of elements i < j, and the place of one.
  static constexpr Index size(Index n) { return n * (n - 1) / 2; }
  static constexpr Index at(Index i, Index j) { return j * (j - 1) / 2 + i; }

  BodyColumns(Index n, bool compensated) : n_(n), compensated_(compensated) {}

  /// Two vectors.
  struct Two {
    PairSums eta, m;
  };
  std::vector<Two>& pairs() { return pairs_; }
  const std::vector<Two>& pairs() const { return pairs_; }
  bool has_frame() const { return has_frame_; }

  /// Takes vectors, which are blocks, at a point of Observables.
  void set(const Dense& point, const Dense& V) {
    const Index rows = V.rows() / n_;
    has_frame_ = rows > n_;
    const auto of_M = static_cast<std::size_t>(size(n_)), of_eta = has_frame_ ? of_M : 0;
    pairs_.assign(static_cast<std::size_t>((V.cols() + 1) / 2),
                  {PairSums(of_eta, compensated_), PairSums(of_M, compensated_)});
    const Dense Q = has_frame_ ? frame(point) : Dense();
    for (Index v = 0; v < V.cols(); ++v) {
      Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      const Dense block = V.col(v).reshaped(rows, n_);
      write(block.bottomRows(n_), v % 2, x.m);
      if (has_frame_) write(Q.transpose() * block.topRows(n_), v % 2, x.eta);
    }
  }

  void read(const Dense& point, Dense& V) const {
    const Index rows = V.rows() / n_;
    const Dense Q = has_frame_ ? frame(point) : Dense();
    for (Index v = 0; v < V.cols(); ++v) {
      const Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      auto block = V.col(v).reshaped(rows, n_);
      block.bottomRows(n_) = matrix(x.m, v % 2);
      if (has_frame_) block.topRows(n_) = Q * matrix(x.eta, v % 2);
    }
  }

 private:
  /// Returns Q at a point, which in three dimensions has it as a quaternion.
  static Dense frame(const Dense& point) {
    if constexpr (N == 3)
      return rotation_matrix<double>(Eigen::Vector4d(point.topRows(4)));
    else
      return point.topRows(point.cols());
  }
  void write(const Dense& A, Index lane, PairSums& out) const {
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i)
        out.set(static_cast<std::size_t>(at(i, j)), static_cast<int>(lane),
                (A(i, j) - A(j, i)) / 2);
  }
  Dense matrix(const PairSums& x, Index lane) const {
    Dense A = Dense::Zero(n_, n_);
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) {
        A(i, j) = x.values()[at(i, j)][static_cast<int>(lane)];
        A(j, i) = -A(i, j);
      }
    return A;
  }

  Index n_;
  bool compensated_, has_frame_ = false;
  std::vector<Two> pairs_;
};

/// The linear maps of one step Q ↦ QU, M ↦ M′ = UᵀMU on elements i < j.
template <int N>
class RotationOfColumns {
 public:
  using Columns = BodyColumns<N>;
  using Index = Eigen::Index;
  static constexpr int d = Columns::d;
  using Square = Eigen::Matrix<double, N, N>;
  using Operator = Eigen::Matrix<double, d, d>;

  explicit RotationOfColumns(Index n)
      : rows_(n, n),
        turned_(n, n),
        turn_(Columns::size(n), Columns::size(n)),
        bracket_(turn_.rows(), turn_.rows()) {}

  /// Takes D = U − I and M′.
  void set(const Square& D, const Square& M1) {
    rows_ = D.transpose();
    turned_ = D;
    turned_.diagonal().array() += 1;
    set_turn(D);
    const Index n = D.rows();
    bracket_.setZero();
    for (Index j = 0; j < n; ++j)
      for (Index i = 0; i < j; ++i)
        for (Index k = 0; k < n; ++k) {
          add(bracket_, Columns::at(i, j), k, j, M1(i, k));
          add(bracket_, Columns::at(i, j), i, k, -M1(k, j));
        }
  }

  /// Adds the coefficient of element (k, l) of a skew matrix to a row of an operator on elements.
  template <class Matrix>
  static void add(Matrix& A, Index row, Index k, Index l, double value) {
    if (k < l) A(row, Columns::at(k, l)) += value;
    if (k > l) A(row, Columns::at(l, k)) -= value;
  }

  /// Adds UᵀXU − X.
  void add_turn(const Pair* x, Pair* sum) const { add_product(turn_, x, sum); }
  /// Adds [M′, υ].
  void add_bracket(const Pair* upsilon, Pair* sum) const { add_product(bracket_, upsilon, sum); }

 private:
  /// Sets the element (i, j), (k, l) to U_ki U_lj − U_li U_kj − δ_ki δ_lj without cancellation.
  void set_turn(const Square& D) {
    const Index n = D.rows();
    double* out = turn_.data();
    for (Index l = 0; l < n; ++l)
      for (Index k = 0; k < l; ++k, out += turn_.rows()) {
        const double *of_k = rows_.data() + n * k, *of_l = rows_.data() + n * l;
        for (Index j = 0; j < n; ++j) {
          const double a = turned_(l, j), b = turned_(k, j);
          double* const column = out + Columns::at(0, j);
          for (Index i = 0; i < j; ++i) column[i] = of_k[i] * a - of_l[i] * b;
          if (k < j) column[k] += D(l, j);
          if (l < j) column[l] -= b;
        }
      }
  }
  static void add_product(const Operator& A, const Pair* x, Pair* sum) {
    const Index size = A.rows();
    const double* a = A.data();
    for (Index k = 0; k < size; ++k)
      for (Index i = 0; i < size; ++i) sum[i] += Pair(*a++) * x[k];
  }

  Square rows_, turned_;  ///< Dᵀ and U
  Operator turn_, bracket_;
};

}  // namespace stiefel
