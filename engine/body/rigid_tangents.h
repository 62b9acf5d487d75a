#pragma once

#include "engine/dense/inertia_operator.h"
#include "engine/dense/so_3.h"
#include "engine/methods/method.h"
#include "engine/motion/tangent_map.h"

namespace stiefel {

/// Returns the tangent of the discrete rigid bodies, `variational` of every order and
/// `preprocessed_variational`.
std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const TangentParameters& at);
/// Returns that of rk4.
std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const TangentParameters& at);
/// Returns that of the closed form in three dimensions.
std::unique_ptr<TangentMap> exact_body_tangent(const Scene& scene, const TangentParameters& at);

/// Those of the methods that move bodies, and of the discrete body.
inline constexpr MethodTangent tangents_of_bodies[] = {
    {method_name::exact, exact_body_tangent, 3},
    {method_name::variational, discrete_body_tangent},
    {method_name::preprocessed, discrete_body_tangent},
    {method_name::rk4, rk4_body_tangent}};
inline constexpr MethodTangent tangents_of_maps[] = {{"", discrete_body_tangent}};

/// Returns Q at a point of Observables that has a frame.
inline Eigen::MatrixXd frame_at(const Eigen::MatrixXd& point) {
  if (point.cols() > 1) return point.topRows(point.cols());
  return rotation_matrix<double>(Eigen::Vector4d(point.topRows(4)));
}

/// Returns a vector (δQ, δM), or δM alone, in N columns as (η, δM) with δQ = Qη, η and δM skew.
inline Eigen::MatrixXd in_body(const Eigen::MatrixXd& point, const Eigen::VectorXd& v) {
  const Eigen::Index N = point.cols() > 1 ? point.cols() : 3;
  Eigen::MatrixXd x = v.reshaped(v.size() / N, N);
  if (x.rows() > N) x.topRows(N) = (frame_at(point).transpose() * x.topRows(N)).eval();
  for (Eigen::Index top = 0; top < x.rows(); top += N)
    x.middleRows(top, N) = skew_part(x.middleRows(top, N));
  return x;
}
/// Returns the vector of (η, δM).
inline Eigen::VectorXd in_space(const Eigen::MatrixXd& point, Eigen::MatrixXd x) {
  const Eigen::Index N = x.cols();
  if (x.rows() > N) x.topRows(N) = (frame_at(point) * x.topRows(N)).eval();
  return x.reshaped();
}

}  // namespace stiefel
