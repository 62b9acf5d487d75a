#pragma once

#include <variant>

#include "engine/body/exact/euler_top.h"
#include "engine/body/exact/two_valued_body.h"

namespace stiefel {

/// The rotation R(t) of a free rigid body since time 0, Q(t) = Q(0)R(t), in closed form. It depends
/// on Λ and on the momentum M(0) alone.
class BodyRotation {
 public:
  using Dense = Matrix<long double>;

  /// Whether there is a closed form: N = 3, or Λ of at most two values.
  static bool has(const Eigen::VectorXd& lambda) {
    return lambda.size() == 3 || TwoValuedBody<long double>::has(lambda);
  }

  BodyRotation(const Vector<long double>& lambda, const Dense& M)
      : motion_(motion(lambda, M)), R_(M) {}

  const Dense& at(long double t) {
    if (auto* top = std::get_if<Top>(&motion_))
      R_ = rotation_matrix<long double>(top->at(t).head<4>());
    else
      R_ = std::get<TwoValuedBody<long double>>(motion_).at(t).topRows(R_.rows());
    return R_;
  }

 private:
  using Top = EulerTop<long double, true>;
  using Motion = std::variant<Top, TwoValuedBody<long double>>;

  static Motion motion(const Vector<long double>& lambda, const Dense& M) {
    const Eigen::Index N = lambda.size();
    if (N == 3) {
      Top::Point start;
      start << 1, 0, 0, 0, vee(M);
      return Top(PrincipalMoments3<long double>(lambda), start);
    }
    Dense start(2 * N, N);
    start << Dense::Identity(N, N), M;
    return TwoValuedBody<long double>(lambda, start);
  }

  Motion motion_;
  Dense R_;
};

/// The free rigid body in variables that its rotation multiplies, in closed form: a state is a
/// stack of N × N blocks, x(t) = x(0)R(t).
class TurnedBody {
 public:
  using Dense = BodyRotation::Dense;

  TurnedBody(BodyRotation rotation, Dense start)
      : rotation_(std::move(rotation)), start_(std::move(start)), x_(start_) {}

  const Dense& at(long double t) {
    x_.noalias() = start_ * rotation_.at(t);
    return x_;
  }

 private:
  BodyRotation rotation_;
  Dense start_, x_;
};

}  // namespace stiefel
