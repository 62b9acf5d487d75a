#pragma once

#include <vector>

#include "engine/dense/decompositions.h"
#include "engine/numbers/scalar.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel::testing {

/// Returns the solution of ẋ = field(x) at time t from x in quadruple precision, by Gragg's
/// extrapolation: the midpoint rule with 2, 4, ..., 24 substeps in each of `steps` steps,
/// extrapolated in h² to order 24. It shares neither methods nor error control with the engine.
template <class Field>
Matrix<Quad> extrapolate(const Field& field, Matrix<Quad> x, const Quad& t, int steps) {
  constexpr std::size_t rows = 12;
  const Quad H = t / steps;
  std::vector<Matrix<Quad>> row(rows), last(rows);
  for (int step = 0; step < steps; ++step) {
    for (std::size_t k = 0; k < rows; ++k) {
      const auto n = static_cast<int>(2 * (k + 1));
      const Quad h = H / n;
      Matrix<Quad> before = x, now = x + h * field(x), next;
      for (int j = 1; j < n; ++j) {
        next = before + 2 * h * field(now);
        before = now;
        now = next;
      }
      row[0] = now;
      for (std::size_t j = 1; j <= k; ++j) {
        const Quad ratio = Quad(k + 1) / Quad(k + 1 - j);
        row[j] = row[j - 1] + (row[j - 1] - last[j - 1]) / (ratio * ratio - 1);
      }
      last = row;
    }
    x = row[rows - 1];
  }
  return x;
}

/// The vector field of [RB] (5.7)–(5.11) as printed. The state is Re Q, Im Q, Re P, Im P, stacked
/// by rows; complex products are computed from real and imaginary parts.
class PrintedDoubleBracket {
 public:
  PrintedDoubleBracket(Vector<Quad> lambda_u, Vector<Quad> lambda_v)
      : lambda_u_(std::move(lambda_u)), lambda_v_(std::move(lambda_v)) {}

  Matrix<Quad> operator()(const Matrix<Quad>& x) const {
    const Eigen::Index p = lambda_u_.size();
    const Complex Q{x.topRows(p), x.middleRows(p, p)}, P{x.middleRows(2 * p, p), x.bottomRows(p)};
    const Complex U = solved(lambda_u_, minus(product(P, adjoint(Q)), product(Q, adjoint(P))));
    const Complex V = solved(lambda_v_, minus(product(adjoint(P), Q), product(adjoint(Q), P)));
    const Complex dQ = minus(product(U, Q), product(Q, V)),
                  dP = minus(product(U, P), product(P, V));
    Matrix<Quad> rate(x.rows(), x.cols());
    rate << dQ.real, dQ.imaginary, dP.real, dP.imaginary;
    return rate;
  }

 private:
  struct Complex {
    Matrix<Quad> real, imaginary;
  };
  static Complex adjoint(const Complex& A) {
    return {A.real.transpose(), -A.imaginary.transpose()};
  }
  static Complex minus(const Complex& A, const Complex& B) {
    return {A.real - B.real, A.imaginary - B.imaginary};
  }
  static Complex product(const Complex& A, const Complex& B) {
    return {A.real * B.real - A.imaginary * B.imaginary,
            A.real * B.imaginary + A.imaginary * B.real};
  }
  /// Returns the X with ΛX + XΛ = A.
  static Complex solved(const Vector<Quad>& lambda, Complex A) {
    for (Eigen::Index i = 0; i < lambda.size(); ++i)
      for (Eigen::Index j = 0; j < lambda.size(); ++j) {
        A.real(i, j) /= lambda(i) + lambda(j);
        A.imaginary(i, j) /= lambda(i) + lambda(j);
      }
    return A;
  }

  Vector<Quad> lambda_u_, lambda_v_;
};

/// The vector field of [RB] (8.4)–(8.6) as printed. The state is Q_μ stacked over P_μ.
class PrintedParametricRigidBody {
 public:
  PrintedParametricRigidBody(Vector<Quad> lambda, Quad mu)
      : lambda_(std::move(lambda)), mu_(std::move(mu)) {}

  /// Returns M = Q⁻¹P − P⁻¹Q − μΛ².
  Matrix<Quad> M(const Matrix<Quad>& x) const {
    const Matrix<Quad> Q = x.topRows(lambda_.size()), P = x.bottomRows(lambda_.size());
    Matrix<Quad> made = Lu<Quad>(Q).solve(P) - Lu<Quad>(P).solve(Q);
    made.diagonal() -= mu_ * lambda_.cwiseAbs2();
    return made;
  }
  Matrix<Quad> operator()(const Matrix<Quad>& x) const {
    Matrix<Quad> xi = M(x);
    for (Eigen::Index i = 0; i < lambda_.size(); ++i)
      for (Eigen::Index j = 0; j < lambda_.size(); ++j) xi(i, j) /= lambda_(i) + lambda_(j);
    xi = ((xi - xi.transpose()) / 2).eval();
    xi.diagonal() = mu_ * lambda_;
    return x * xi;
  }

 private:
  Vector<Quad> lambda_;
  Quad mu_;
};

}  // namespace stiefel::testing
