#pragma once

#include <Eigen/Core>
#include <type_traits>

#include "engine/numbers/isa.h"

namespace stiefel {

/// Computes the m × c matrix out = AB from columns in memory: column j of A begins at A + j lda,
/// and so on. m is a multiple of 8, and A has k columns. Every element is a sum in the order of the
/// columns of A without fused operations, so that its bits are those of every instruction set. For
/// matrices that fit into the nearest caches.
template <Isa isa>
void small_product_on(Eigen::Index m, Eigen::Index k, Eigen::Index c, const double* A,
                      Eigen::Index lda, const double* B, Eigen::Index ldb, double* out,
                      Eigen::Index ldo);

using SmallProduct = std::add_pointer_t<decltype(small_product_on<Isa::baseline>)>;

/// Returns the product for the widest instruction set of this machine.
inline SmallProduct small_product() {
#ifdef STIEFEL_X86_64
  if (widest_isa() == Isa::avx512) return small_product_on<Isa::avx512>;
  if (widest_isa() == Isa::avx2) return small_product_on<Isa::avx2>;
#endif
  return small_product_on<Isa::baseline>;
}

}  // namespace stiefel
