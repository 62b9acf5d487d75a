#pragma once

#include "engine/body/j_d/cayley_n.h"
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

}  // namespace stiefel

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing
