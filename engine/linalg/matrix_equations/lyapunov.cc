#include "engine/linalg/matrix_equations/lyapunov.h"

namespace stiefel {

template class Lyapunov<double>;
template class Lyapunov<long double>;
template class Lyapunov<float>;

}  // namespace stiefel
