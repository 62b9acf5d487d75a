#include "engine/rigid_body/j_d/cayley_n.h"

namespace stiefel {

template class CayleyN<double>;

}  // namespace stiefel
