#include "engine/linalg/matrix_equations/lu.h"

template class Eigen::PartialPivLU<stiefel::Matrix<double>>;
template class Eigen::PartialPivLU<stiefel::Matrix<long double>>;
