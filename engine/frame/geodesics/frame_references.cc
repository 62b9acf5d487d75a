// The references for geodesics on V(n, N).
#include "engine/accuracy/taylor_reference.h"
#include "engine/frame/geodesics/isotropic_geodesic.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/frame/taylor_stiefel.h"

namespace stiefel {

template class IsotropicGeodesic<double>;
template class IsotropicGeodesic<long double>;
template class TaylorStiefel<long double>;
template class TaylorMotion<TaylorStiefel<long double>>;

namespace {

using Start = SeriesStart<Quad>;

template <class Scalar>
Solution isotropic_geodesic(const Start& start) {
  return [as = reported_form<Scalar>(start), n = start.x.rows() / 2,
          motion = IsotropicGeodesic<Scalar>(rounded<Scalar>(start.lambda),
                                             rounded<Scalar>(start.x))](double t) mutable {
    return present<Shown<Scalar>>(as, rounded<Shown<Scalar>>(motion.at(Scalar(t))), n);
  };
}

bool has_closed_form(const Eigen::VectorXd& lambda) {
  return lambda.size() > 1 && IsotropicGeodesic<double>::has(lambda);
}

std::unique_ptr<Reference> closed_form(const Start& start, const ReferenceNeed& need, double time,
                                       double allowed) {
  const double work = eigenvectors_work(start.x.rows(), start.x.cols());
  if (work > allowed) return nullptr;
  const Eigen::Index rows = start.x.rows() / 2;
  const Matrix<Quad> Q = start.x.topRows(rows);
  const Matrix<Quad> defect = Q * Q.transpose() - Matrix<Quad>::Identity(rows, rows);
  const double S = start.x.bottomRows(rows).cast<double>().norm();
  return closed_form_reference(
      {isotropic_geodesic<long double>(start), isotropic_geodesic<double>(start), in_extended,
       S / static_cast<double>(start.lambda(0)), work,
       "closed form for Lambda a multiple of the identity in extended precision",
       defect.cast<double>().norm()},
      need, time);
}

std::unique_ptr<Reference> series(const SeriesStart<long double>& start,
                                  const ReferenceNeed& need) {
  const auto make = [&](int order) {
    return TaylorStiefel<long double>(start.lambda, start.x.rows() / 2, order);
  };
  return taylor_reference(make, start, need);
}

}  // namespace

constinit const SeriesEquations frame_equations = {series, has_closed_form, closed_form};

}  // namespace stiefel
