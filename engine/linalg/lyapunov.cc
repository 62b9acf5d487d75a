#include "engine/linalg/lyapunov.h"

namespace stiefel {

template class Lyapunov<double>;

}  // namespace stiefel
