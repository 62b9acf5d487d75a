#include "engine/numbers/eigen_products.h"

STIEFEL_EIGEN_PRODUCTS(, float)
STIEFEL_EIGEN_PRODUCTS(, double)
STIEFEL_EIGEN_PRODUCTS(, long double)
