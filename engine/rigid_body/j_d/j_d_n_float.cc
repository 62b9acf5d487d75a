#include "engine/rigid_body/j_d/j_d_n.h"

namespace stiefel {

template class JDInverseN<float>;

}  // namespace stiefel
