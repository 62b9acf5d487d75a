#include "engine/linalg/symmetric_lyapunov.h"

namespace stiefel {

template class SymmetricLyapunov<double>;

}  // namespace stiefel
