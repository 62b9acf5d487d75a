#include "engine/structure/dirac_bracket.h"

#include "engine/dense/decompositions.h"
#include "stiefel/stop.h"

namespace stiefel {

Jet jet_of(const PairFactors& function, const Matrix<double>& Q, const Matrix<double>& P) {
  Jet jet{1, Matrix<double>::Zero(Q.rows(), Q.cols()), Matrix<double>::Zero(Q.rows(), Q.cols())};
  for (const auto& [A, B] : function.factors) {
    stop_point(6 * static_cast<double>(Q.size()));
    const double f = trace_product(A, Q) + trace_product(B, P);
    jet.by_Q = f * jet.by_Q + 2 * jet.value * A;
    jet.by_P = f * jet.by_P + 2 * jet.value * B;
    jet.value *= f;
  }
  return jet;
}

double dirac_bracket(const Matrix<double>& Q, const Matrix<double>& P, const PairFactors& F,
                     const PairFactors& K) {
  const auto f = jet_of(F, Q, P), k = jet_of(K, Q, P);
  const auto inner = [](const Matrix<double>& X, const Matrix<double>& Y) {
    return trace_product(X, Y) / 2;
  };
  const auto twice_symmetric = [](const Matrix<double>& X) -> Matrix<double> {
    stop_point(2 * static_cast<double>(X.rows() * X.size()));
    return X + X.transpose();
  };
  const Matrix<double> R = Q * P.transpose();
  // (I + R ⊗ Rᵀ)⁻¹ of [RB] (3.15): R is orthogonal, so Y + RYR = RG is RᵀY + YR = G.
  Lyapunov<double> equation(R.rows());
  equation.factor(R);
  const auto solve = [&](const Matrix<double>& G) {
    Matrix<double> Y(G.rows(), G.cols());
    equation.solve(G, Y);
    return Y;
  };
  return inner(k.by_P, f.by_Q) - inner(k.by_Q, f.by_P) -
         inner(twice_symmetric(k.by_P * Q.transpose()),
               solve(twice_symmetric(f.by_Q * P.transpose()))) /
             2 +
         inner(twice_symmetric(k.by_Q * P.transpose()),
               solve(R.transpose() * twice_symmetric(f.by_P * Q.transpose()) * R)) /
             2;
}

}  // namespace stiefel
