#include "engine/moser_veselov/cayley_n.h"

namespace stiefel {

template class CayleyN<float>;

}  // namespace stiefel
