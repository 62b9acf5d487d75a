#include "engine/maps/rattle_stiefel.h"

namespace stiefel {

template class RattleStiefel<float>;

}  // namespace stiefel
