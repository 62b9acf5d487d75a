#include "engine/rigid_body/j_d/j_d_n.h"

namespace stiefel {

template class JDInverseN<double, Arithmetic::compensated>;
template class JDInverseN<double, Arithmetic::plain>;

}  // namespace stiefel
