#include "engine/linalg/cayley_n.h"

namespace stiefel {

template class CayleyN<double>;

}  // namespace stiefel
