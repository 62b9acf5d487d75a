#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;

}  // namespace stiefel
