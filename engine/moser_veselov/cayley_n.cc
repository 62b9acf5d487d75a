#include "engine/moser_veselov/cayley_n.h"

namespace stiefel {

template class CayleyN<double>;

}  // namespace stiefel
