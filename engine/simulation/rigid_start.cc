#include "engine/simulation/rigid_start.h"

#include <Eigen/Eigenvalues>

#include "engine/linalg/so_3.h"
#include "engine/representations/mclachlan_scovel.h"

namespace stiefel {
namespace {

using Wide = Matrix<Quad>;

Wide quadruple(const Eigen::MatrixXd& A) { return A.cast<Quad>(); }

Wide momentum_of_pair(const Wide& Q, const Wide& P, const Quad& epsilon) {
  const Wide R = Q.transpose() * P;
  return (R - R.transpose()) / epsilon;
}

/// M = Qᵀ(A − Aᵀ)Q/ε, A = PQᵀ: the other where Q is orthogonal, which a Q of doubles is not quite.
Wide momentum_of_constant(const Wide& Q, const Wide& P, const Quad& epsilon) {
  const Wide A = P * Q.transpose();
  return Q.transpose() * (A - A.transpose()) * Q / epsilon;
}

Vector3<Quad> vector(const std::vector<double>& v) {
  return Vector3<Quad>(Quad(v[0]), Quad(v[1]), Quad(v[2]));
}

PrincipalMoments3<Quad> with_differences(const Vector3<Quad>& I) {
  return {I, Vector3<Quad>(I(1) - I(2), I(2) - I(0), I(0) - I(1))};
}

/// The principal moments and axes, the latter only where they are not the caller's.
void set_axes(const BodyDescription& body, RigidStart& start) {
  if (body.inertia_tensor.empty()) {
    start.moments = with_differences(vector(body.moments));
    return;
  }
  const auto& t = body.inertia_tensor;
  if (t[3] == 0 && t[4] == 0 && t[5] == 0) {
    start.moments = with_differences(vector(t));
    return;
  }
  Eigen::Matrix<Quad, 3, 3> I;
  I << Quad(t[0]), Quad(t[3]), Quad(t[4]), Quad(t[3]), Quad(t[1]), Quad(t[5]), Quad(t[4]),
      Quad(t[5]), Quad(t[2]);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<Quad, 3, 3>> solver(I);
  Eigen::Matrix<Quad, 3, 3> R = solver.eigenvectors();
  if (R.col(0).dot(R.col(1).cross(R.col(2))) < 0) R.col(0) = -R.col(0);
  start.moments = with_differences(solver.eigenvalues());
  start.axes = R;
}

RigidStart of_body(const Scene& scene) {
  const BodyDescription& body = *scene.description().body;
  RigidStart start;
  start.lambda = scene.inertia().cast<Quad>();
  set_axes(body, start);
  Eigen::Matrix<Quad, 4, 1> q = Eigen::Vector4d(body.attitude.data()).cast<Quad>();
  q /= sqrt(q.squaredNorm());
  start.Q = rotation_matrix<Quad>(q);
  Vector3<Quad> omega = vector(body.angular_velocity);
  if (start.axes.size() > 0) {
    start.Q = (start.Q * start.axes).eval();
    omega = (start.axes.transpose() * omega).eval();
  }
  start.M = hat(Vector3<Quad>(start.moments->moments.cwiseProduct(omega)));
  return start;
}

}  // namespace

MotionState RigidStart::presented(Matrix<long double> attitude,
                                  Matrix<long double> momentum) const {
  if (axes.size() > 0) {
    const Matrix<long double> R = axes.cast<long double>();
    if (attitude.size() > 0) attitude = (attitude * R.transpose()).eval();
    momentum = (R * momentum * R.transpose()).eval();
  }
  if (right) {
    attitude.transposeInPlace();
    momentum = -momentum;
  }
  return {std::move(attitude), std::move(momentum)};
}

std::optional<RigidStart> rigid_start(const Scene& scene) {
  const std::string& system = scene.system();
  if (scene.description().body) return of_body(scene);
  const bool pair = system.ends_with("symmetric_rigid_body");
  const bool reduced = system == "reduced_rigid_body", B = system == "mclachlan_scovel";
  const bool M = system == "rigid_body" || system == "right_rigid_body";
  if (!pair && !reduced && !B && !M) return std::nullopt;
  RigidStart start;
  start.right = system.starts_with("right_");
  start.lambda = scene.inertia().cast<Quad>();
  if (scene.dimension() == 3) start.moments.emplace(scene.inertia());
  start.Q = quadruple(scene.Q());
  if (start.right) start.Q.transposeInPlace();
  if (pair) {
    Wide P = quadruple(scene.block("P"));
    if (start.right) P.transposeInPlace();
    start.M = momentum_of_pair(start.Q, P, scene.epsilon());
  } else if (reduced) {
    start.M = momentum_of_constant(start.Q, quadruple(scene.block("P")), scene.epsilon());
  } else if (B) {
    start.M = M_of_B(start.Q, quadruple(scene.block("B")));
  } else {
    start.M = quadruple(scene.M());
    if (start.right) start.M *= Quad(-1);
  }
  return start;
}

}  // namespace stiefel
