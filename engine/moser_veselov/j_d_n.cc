#include "engine/moser_veselov/j_d_n.h"

namespace stiefel {

template class JDInverseN<double>;

}  // namespace stiefel
