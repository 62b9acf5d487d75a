#pragma once

#include <string>

#include "stiefel/scene.h"

namespace stiefel::extremes {

/// Returns a rigid body in N dimensions, without a method.
SceneDescription rigid_body(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                            const Eigen::MatrixXd& M, double step);
/// Returns a rigid body in three dimensions with given principal moments and m in body axes; Q is a
/// seeded rotation.
SceneDescription top(const Eigen::Vector3d& moments, const Eigen::Vector3d& m, double step);
/// Returns a rigid body in N dimensions with a full Ω of norm 1; Q is a seeded rotation.
SceneDescription tumbling(const Eigen::VectorXd& lambda, double step, unsigned seed = 1);
/// Returns a geodesic on V(n, N) with ‖Q̇‖_op = 1.
SceneDescription geodesic(Eigen::Index n, const Eigen::VectorXd& lambda, double step,
                          unsigned seed = 1);

/// Returns λ_1..λ_N from 1 to `spread`, in a geometric series.
Eigen::VectorXd spread_inertia(int N, double spread);

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, unsigned seed);
/// Returns a random matrix with orthonormal rows; a rotation if it is square.
Eigen::MatrixXd random_frame(Eigen::Index n, Eigen::Index N, unsigned seed);

/// Returns the largest singular value.
double norm(const Eigen::MatrixXd& A);

}  // namespace stiefel::extremes
