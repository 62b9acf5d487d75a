#include "engine/rigid_body/body/skew_norm.h"

namespace stiefel {

template double skew_norm(const Matrix<double>& M);

}  // namespace stiefel
