// The references for motions of rigid bodies.
#include <cmath>

#include "engine/accuracy/taylor_reference.h"
#include "engine/body/exact/turned_body.h"
#include "engine/body/rigid_body_data.h"
#include "engine/dense/taylor_rigid_body.h"

namespace stiefel {

template class EulerTop<long double>;
template class TwoValuedBody<double>;
template class TwoValuedBody<long double>;
template class TaylorRigidBody<long double>;
template class TaylorRigidBody<long double, true>;
template class TaylorMotion<TaylorRigidBody<long double>>;
template class TaylorMotion<TaylorRigidBody<long double, true>>;

namespace {

using Start = SeriesStart<Quad>;

constexpr double top_in_quadruple = 1.4e6;  // units of work, as top_in_extended

/// Returns the motion of Euler's top that starts at Q = I, multiplied by Q_0 from the left.
template <class Scalar>
Solution top(const Start& start) {
  typename EulerTop<Scalar>::Point x;
  const Matrix<Quad> M = start.x.bottomRows(3);
  x << Scalar(1), Scalar(0), Scalar(0), Scalar(0), vee(rounded<Scalar>(M));
  const PrincipalMoments3<Quad> I(start.lambda);
  const PrincipalMoments3<Scalar> moments(rounded<Scalar>(I.moments),
                                          rounded<Scalar>(I.differences));
  using Wide = Shown<Scalar>;
  return
      [as = reported_form<Scalar>(start), Q_0 = rounded<Wide>(start.x.topRows(start.x.rows() - 3)),
       motion = EulerTop<Scalar>(moments, x)](double t) {
        const auto at = motion.at(Scalar(t));
        Matrix<Wide> now(Q_0.rows() + 3, 3);
        if (Q_0.rows() > 0)
          now.topRows(3) = Q_0 * rounded<Wide>(rotation_matrix<Scalar>(at.template head<4>()));
        now.bottomRows(3) = rounded<Wide>(hat(Vector3<Scalar>(at.template tail<3>())));
        return present(as, now, 3);
      };
}

template <class Scalar>
Solution two_valued(const Start& start) {
  return [as = reported_form<Scalar>(start), N = start.x.cols(),
          motion = TwoValuedBody<Scalar>(rounded<Scalar>(start.lambda), rounded<Scalar>(start.x))](
             double t) mutable {
    return present<Shown<Scalar>>(as, rounded<Shown<Scalar>>(motion.at(Scalar(t))), N);
  };
}

/// Returns ‖Ω‖_F, Ω_ij = M_ij/(λ_i + λ_j).
double body_rate(const Start& start) {
  const Eigen::Index N = start.x.cols();
  const auto M = start.x.bottomRows(N);
  double sum = 0;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      const auto Omega =
          static_cast<double>(M(i, j)) / static_cast<double>(start.lambda(i) + start.lambda(j));
      sum += 2 * Omega * Omega;
    }
  return std::sqrt(sum);
}

ComparedForm top_form(const Start& start, bool quadruple) {
  if (quadruple)
    return {top<Quad>(start), top<long double>(start),
            in_quadruple,     body_rate(start),
            top_in_quadruple, "Jacobi's closed form in quadruple precision"};
  return {
      top<long double>(start), top<double>(start), in_extended,
      body_rate(start),        top_in_extended,    "Jacobi's closed form in extended precision"};
}

std::unique_ptr<Reference> closed_form(const Start& start, const ReferenceNeed& need, double time,
                                       double allowed) {
  const Eigen::Index N = start.x.cols();
  const double work = N == 3 ? top_in_extended : eigenvectors_work(N, N);
  if (work > allowed) return nullptr;
  if (N == 3) {
    for (const bool quadruple : {need.quadruple, true})
      if (auto made = closed_form_reference(top_form(start, quadruple), need, time)) return made;
    return nullptr;
  }
  return closed_form_reference(
      {two_valued<long double>(start), two_valued<double>(start), in_extended, body_rate(start),
       work, "closed form for Lambda of two values in extended precision"},
      need, time);
}

template <bool parametric>
std::unique_ptr<Reference> series(const SeriesStart<long double>& start,
                                  const ReferenceNeed& need) {
  const auto make = [&](int order) {
    return TaylorRigidBody<long double, parametric>(start.lambda, start.mu, order);
  };
  return taylor_reference(make, start, need);
}

}  // namespace

constinit const SeriesEquations body_equations = {series<false>, TurnedBody::has, closed_form};
constinit const SeriesEquations parametric_equations = {series<true>};

}  // namespace stiefel
