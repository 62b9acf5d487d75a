#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class SymmetricLyapunov<double>;
template class SymmetricLyapunov<float>;

}  // namespace stiefel
