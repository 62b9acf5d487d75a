#include "engine/rigid_body/body/body_invariants.h"

namespace stiefel {

template Vector<double> casimirs(const Matrix<double>& M);

}  // namespace stiefel
