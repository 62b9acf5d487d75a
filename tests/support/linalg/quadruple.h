#pragma once

#include "engine/body/moser_veselov.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/numbers/quadruple.h"

namespace stiefel {

// What the variational step takes of a number in double alone. Its templates find these by their
// argument.
inline int ilogb(Quad x) { return ilogbq(x.value()); }
inline void upper_gram(const Matrix<Quad>& A, Matrix<Quad>& out) {
  out.noalias() = A.transpose() * A;
}

// The templates of the variational step whose compilation in quadruple precision takes longest are
// compiled once, in quadruple.cc and quadruple_cayley.cc.
extern template class Lyapunov<Quad>;
extern template class ConstraintRiccati<Quad>;
extern template class RattleStiefel<Quad>;
extern template class CayleyN<Quad>;

/// J_D⁻¹ in more digits than the engine's, by Newton's method in the Cayley form.
template <class Scalar>
class WideJDInverse {
 public:
  using State = Accumulator<Matrix<Scalar>>;
  using Memory = NoMemory;

  WideJDInverse(const Vector<Scalar>& lambda, Scalar h) : h_(h), cayley_(lambda, h) {}

  Memory memory(const auto&) const { return {}; }
  bool solve(const State& x, const Memory&) {
    restart();
    return continue_to(x, 1);
  }
  bool continue_to(const State& x, double t) {
    return cayley_.newton((Scalar(t) * h_) * x.value.bottomRows(x.value.cols()));
  }
  void restart() { cayley_.C().setZero(); }
  void transport(State& x, Memory&) { cayley_.transport(x); }

 private:
  Scalar h_;
  CayleyN<Scalar> cayley_;
};
template <>
struct JDInverseOf<SoN<long double>> {
  using type = WideJDInverse<long double>;
};
template <>
struct JDInverseOf<SoN<Quad>> {
  using type = WideJDInverse<Quad>;
};

}  // namespace stiefel

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing
