#pragma once

#include "engine/linalg/arithmetic/quadruple.h"
#include "engine/maps/rattle_stiefel.h"
#include "engine/moser_veselov/cayley_n.h"

namespace stiefel {

// The templates of the variational step whose compilation in quadruple precision takes longest are
// compiled once, in quadruple.cc and quadruple_cayley.cc.
extern template class Lyapunov<Quad>;
extern template class ConstraintRiccati<Quad>;
extern template class RattleStiefel<Quad>;
extern template class CayleyN<Quad>;

}  // namespace stiefel

extern template class Eigen::PartialPivLU<stiefel::Matrix<stiefel::Quad>>;

namespace stiefel::testing {

using stiefel::Quad;

}  // namespace stiefel::testing
