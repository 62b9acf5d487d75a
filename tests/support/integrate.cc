#include "tests/support/integrate.h"

namespace stiefel::testing {

template Matrix<long double> integrate(Stiefel<long double> system,
                                       const Matrix<long double>& start, long double t,
                                       long double tolerance);

}  // namespace stiefel::testing
