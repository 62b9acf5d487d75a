#include "engine/linalg/matrix_equations/lyapunov.h"

namespace stiefel {

template class Lyapunov<float>;

}  // namespace stiefel
