#pragma once

#include "engine/body/j_d/cayley_n.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/numbers/quadruple.h"

namespace stiefel {

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
