#include "engine/frames/passes/rattle_stiefel.h"

namespace stiefel {

template class RattleStiefel<float, Arithmetic::compensated>;
template class RattleStiefel<float, Arithmetic::plain>;

}  // namespace stiefel
