#include "engine/frame/rattle_stiefel.h"

namespace stiefel {

template class FramePass<double>;
template class RattleStiefel<double>;

}  // namespace stiefel
