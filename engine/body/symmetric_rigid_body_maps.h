#pragma once

#include "engine/body/exact/turned_body.h"
#include "engine/body/psi.h"
#include "engine/body/symmetric_moser_veselov.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"

namespace stiefel {

// The maps of methods that are made for the symmetric representation: (SDRBn), which is the
// Moser–Veselov map under Ψ, and the closed form.

template <class Scalar>
auto map_of(Variational, const SymmetricRigidBody<Scalar>& body, Scalar h,
            const MethodOptions& options) {
  return composed(
      [body](Scalar stage, Arithmetic arithmetic) {
        return SymmetricMoserVeselov<Scalar>(body.lambda(), stage, body.epsilon(), arithmetic);
      },
      h, options);
}

template <class Scalar>
auto map_of(Exact, const SymmetricRigidBody<Scalar>& body, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  return closed_form_map<Matrix<Scalar>>(
      [body](const Matrix<Scalar>& start) -> TurnedBody<Wide> {
        const Matrix<Wide> x = start.template cast<Wide>();
        const Matrix<Wide> Q = x.topRows(x.cols()), P = x.bottomRows(x.cols());
        const Wide epsilon = body.epsilon();
        return {{body.lambda().template cast<Wide>(), Psi(Q, P, epsilon)}, x};
      },
      h);
}
template <class Scalar>
inline constexpr Declared declared<Exact, SymmetricRigidBody<Scalar>> = {
    .where = "N = 3, or Lambda of at most two values",
    .takes = BodyRotation<Extended<Scalar>>::has};

}  // namespace stiefel
