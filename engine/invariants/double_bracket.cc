#include "engine/invariants/double_bracket.h"

namespace stiefel {

template Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                                        const Matrix<std::complex<double>>& P,
                                        std::complex<double> a, std::complex<double> b);

}  // namespace stiefel
