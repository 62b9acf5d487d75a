#pragma once

#include "engine/methods/support/concepts.h"

namespace stiefel {

/// Brockett's double bracket flow (Brockett 1991) of a symmetric H, a system without frame and
/// momentum:
///
///     H' = [[D, H], H],   D = diag(d).
///
/// It keeps the eigenvalues of H, tr(DH) never falls, and H is at rest where it is diagonal.
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

}  // namespace stiefel
