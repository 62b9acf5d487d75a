#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class SymmetricLyapunov<double>;
template class SymmetricLyapunov<float>;
template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;

}  // namespace stiefel
