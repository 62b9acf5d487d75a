#include "engine/frames/passes/rattle_stiefel.h"

namespace stiefel {

template class FramePass<double>;
template class RattleStiefel<double, Arithmetic::compensated>;
template class RattleStiefel<double, Arithmetic::plain>;
template class RattleStiefel<double, Arithmetic::compensated, LowerBlock::Qdot>;
template class RattleStiefel<double, Arithmetic::plain, LowerBlock::Qdot>;

}  // namespace stiefel
