#include "tests/extremes/twin/twin_in_many.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel::extremes {

std::unique_ptr<Twin> twin_in_many_wide(const Scene& scene, Perturbation moved) {
  return twin_in_many_in<long double>(scene, moved);
}

}  // namespace stiefel::extremes
