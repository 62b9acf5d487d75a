#include "engine/rigid_body/j_d/cayley_n.h"

namespace stiefel {

template class CayleyN<double>;
template class CayleyN<float>;

}  // namespace stiefel
