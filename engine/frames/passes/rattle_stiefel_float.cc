#include "engine/frames/passes/rattle_stiefel.h"

namespace stiefel {

template class RattleStiefel<float>;

}  // namespace stiefel
