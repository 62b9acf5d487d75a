#pragma once

#include <variant>

#include "engine/body/exact/euler_top.h"
#include "engine/body/exact/two_valued_body.h"

namespace stiefel {

/// The rotation R(t) of a free rigid body since time 0, Q(t) = Q(0)R(t), in closed form. It depends
/// on Λ and on the momentum M(0) alone.
template <class Scalar>
class BodyRotation {
 public:
  /// Whether there is a closed form: N = 3, or Λ of at most two values.
  static bool has(const Vector<double>& lambda) {
    return lambda.size() == 3 || TwoValuedBody<Scalar>::has(lambda);
  }

  BodyRotation(const Vector<Scalar>& lambda, const Matrix<Scalar>& M)
      : motion_(motion(lambda, M)), R_(M) {}

  const Matrix<Scalar>& at(Scalar t);

 private:
  using Top = EulerTop<Scalar, true>;
  using Motion = std::variant<Top, TwoValuedBody<Scalar>>;

  static Motion motion(const Vector<Scalar>& lambda, const Matrix<Scalar>& M);

  Motion motion_;
  Matrix<Scalar> R_;
};

/// The free rigid body in variables that its rotation multiplies, in closed form: a state is a
/// stack of N × N blocks, x(t) = x(0)R(t).
template <class Scalar>
class TurnedBody {
 public:
  TurnedBody(BodyRotation<Scalar> rotation, Matrix<Scalar> start)
      : rotation_(std::move(rotation)), start_(std::move(start)), x_(start_) {}

  const Matrix<Scalar>& at(Scalar t) {
    x_.noalias() = start_ * rotation_.at(t);
    return x_;
  }

 private:
  BodyRotation<Scalar> rotation_;
  Matrix<Scalar> start_, x_;
};

template <class Scalar>
const Matrix<Scalar>& BodyRotation<Scalar>::at(Scalar t) {
  if (auto* top = std::get_if<Top>(&motion_))
    R_ = rotation_matrix<Scalar>(top->at(t).template head<4>());
  else
    R_ = std::get<TwoValuedBody<Scalar>>(motion_).at(t).topRows(R_.rows());
  return R_;
}

template <class Scalar>
typename BodyRotation<Scalar>::Motion BodyRotation<Scalar>::motion(const Vector<Scalar>& lambda,
                                                                   const Matrix<Scalar>& M) {
  const Eigen::Index N = lambda.size();
  if (N == 3) {
    typename So3<Scalar, true>::State start;
    start << 1, 0, 0, 0, vee(M);
    return Top(PrincipalMoments3<Scalar>(lambda), start);
  }
  Matrix<Scalar> start(2 * N, N);
  start << Matrix<Scalar>::Identity(N, N), M;
  return TwoValuedBody<Scalar>(lambda, start);
}

// Compiled once, in closed_forms.cc.
extern template class BodyRotation<long double>;
extern template class TurnedBody<long double>;

}  // namespace stiefel
