#include "tests/support/linalg/quadruple.h"

#include "engine/frames/passes/frame_pass_on.h"

namespace stiefel {

template class Lyapunov<Quad>;
template class ConstraintRiccati<Quad>;
template class RattleStiefel<Quad>;

}  // namespace stiefel
