#include "engine/rigid_body/j_d/cayley_n.h"

namespace stiefel {

template class CayleyN<float, Arithmetic::compensated>;
template class CayleyN<float, Arithmetic::plain>;

}  // namespace stiefel
