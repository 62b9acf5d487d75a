#pragma once

#include "engine/systems/concepts.h"

namespace stiefel::testing {

/// Brockett's double bracket flow (Brockett 1991)
///
///     H' = [[D, H], H],   D = diag(d),
///
/// of a symmetric H. It keeps the eigenvalues of H, tr(DH) never falls, and H comes to rest where
/// it is diagonal. A system without frame and momentum.
template <class Scalar_>
class Brockett {
 public:
  static constexpr const char* name = "brockett";
  using Scalar = Scalar_;
  using State = Matrix<Scalar>;

  explicit Brockett(Vector<Scalar> d) : d_(std::move(d)) {}

  void field(const State& H, State& dH) {
    bracket_ = d_.asDiagonal() * H;
    bracket_ -= H * d_.asDiagonal();
    dH.noalias() = bracket_ * H;
    dH.noalias() -= H * bracket_;
  }

 private:
  Vector<Scalar> d_;
  State bracket_;
};

}  // namespace stiefel::testing
