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

inline auto map_of(Variational, const SymmetricRigidBody<double>& body, double h,
                   const MethodOptions& options) {
  return composed(
      [body](double stage, Arithmetic arithmetic) {
        return SymmetricMoserVeselov(body.lambda(), stage, body.epsilon(), arithmetic);
      },
      h, options);
}

inline auto map_of(Exact, const SymmetricRigidBody<double>& body, double h, const MethodOptions&) {
  return closed_form_map<Eigen::MatrixXd>(
      [body](const Eigen::MatrixXd& start) -> TurnedBody {
        const TurnedBody::Dense x = start.cast<long double>(), Q = x.topRows(x.cols()),
                                P = x.bottomRows(x.cols());
        const long double epsilon = body.epsilon();
        return {{body.lambda().cast<long double>(), Psi(Q, P, epsilon)}, x};
      },
      h);
}
template <>
inline constexpr Declared declared<Exact, SymmetricRigidBody<double>> = {
    .where = "N = 3, or Lambda of at most two values", .takes = BodyRotation::has};

}  // namespace stiefel
