#include "engine/moser_veselov/j_d_n.h"

namespace stiefel {

template class JDInverseN<double, Arithmetic::compensated>;
template class JDInverseN<double, Arithmetic::plain>;

}  // namespace stiefel
