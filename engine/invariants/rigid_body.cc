#include "engine/invariants/rigid_body.h"

namespace stiefel {

template Vector<double> casimirs(const Matrix<double>& M);

}  // namespace stiefel
