#include "engine/body/psi.h"

namespace stiefel {

template double principal_cosine(const Matrix<double>& Q, const Matrix<double>& P);
template MatrixWithin<double> root_of_one_plus_square(const Matrix<double>& A);

}  // namespace stiefel
