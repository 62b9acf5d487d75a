#include "engine/numbers/eigen_products.h"

#include "engine/numbers/quadruple.h"

STIEFEL_EIGEN_PRODUCTS(, float)
STIEFEL_EIGEN_PRODUCTS(, double)
STIEFEL_EIGEN_PRODUCTS(, long double)
STIEFEL_EIGEN_PRODUCTS(, stiefel::Quad)
