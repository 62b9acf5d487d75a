#include "engine/body/rigid_body_observables.h"

#include <cmath>
#include <limits>

#include "engine/body/rigid_body_invariants.h"
#include "engine/body/view.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "engine/motion/system_entry.h"

namespace stiefel {
namespace {

using Coordinates3 = So3<double, true>;

Eigen::Vector3d m(const Eigen::MatrixXd& x) { return x.bottomRows<3>(); }

/// Appends the fields of the scene to `fields`, and sets `block_count`.
RigidBodyOffer offer(const Scene& scene, std::vector<Field>& fields, std::size_t& block_count) {
  RigidBodyOffer all;
  const int N = scene.dimension();
  const auto add = [&](const char* name, RigidBodyField kind, int rows, int cols) {
    fields.push_back({name, rows, cols});
    all.kinds.push_back(kind);
  };
  if (scene.has_frame()) add("Q", RigidBodyField::Q, N, N);
  add("M", RigidBodyField::M, N, N);
  block_count = fields.size();
  add("Omega", RigidBodyField::Omega, N, N);
  if (N == 3 && scene.has_frame() && scene.determinant() == 1)
    add("quaternion", RigidBodyField::quaternion, 1, 4);
  if (N == 3) add("angular_velocity", RigidBodyField::angular_velocity, 1, 3);
  if (N == 3 && scene.has_frame()) {
    add("angular_velocity_space", RigidBodyField::angular_velocity_space, 1, 3);
    add("momentum_space", RigidBodyField::momentum_space, 1, 3);
  }
  if (scene.method().empty()) all.map_step = scene.step();
  return all;
}

}  // namespace

RigidBodyObservables::RigidBodyObservables(const Scene& scene)
    : offer_(offer(scene, fields_, block_count_)),
      lambda_(scene.inertia()),
      N_(scene.dimension()) {}

auto RigidBodyObservables::start(const Scene& scene) const -> Point {
  Point x(scene.Q().rows() + N_, N_);
  if (x.rows() > N_) x.topRows(N_) = scene.Q();
  x.bottomRows(N_) = scene.M();
  return x;
}

void RigidBodyObservables::write(const Point& x, std::size_t index, std::span<double> out) const {
  Eigen::Map<RowMatrix> block(out.data(), N_, N_);
  switch (offer_.kinds[index]) {
    case RigidBodyField::Q:
      block = x.topRows(N_);
      break;
    case RigidBodyField::M:
      block = x.bottomRows(N_);
      break;
    default: {
      Eigen::MatrixXd Omega(N_, N_);
      SoN<double>::inverse_inertia(lambda_, x, Omega);
      block = Omega;
    }
  }
}

void RigidBodyObservables::invariants(const Point& x, InvariantList& out) const {
  rigid_body_invariants(Side::left, lambda_, x.topRows(x.rows() - N_), x.bottomRows(N_), out);
  if (offer_.map_step) add_discrete_hamiltonian(lambda_, x.bottomRows(N_), *offer_.map_step, out);
}

std::optional<double> RigidBodyObservables::orthogonality(const Point& x) const {
  if (x.rows() == N_) return std::nullopt;
  return orthogonality_defect(x.topRows(N_));
}

double RigidBodyObservables::rate(const Point& x) const {
  return angular_velocity_norm(lambda_, x.bottomRows(N_));
}

RigidBodyObservables3::RigidBodyObservables3(const Scene& scene)
    : offer_(offer(scene, fields_, block_count_)),
      lambda_(scene.inertia()),
      frame_(scene.has_frame()),
      determinant_(scene.determinant()) {
  if (!scene.axes()) return;
  R_ = scene.axes()->rotation;
  r_conjugate_ = quaternion_of(*R_);
  r_conjugate_.tail<3>() = -r_conjugate_.tail<3>();
}

auto RigidBodyObservables3::start(const Scene& scene) const -> Point {
  Point x(frame_ ? 7 : 3, 1);
  if (frame_) x.topRows<4>() = scene.attitude();
  x.bottomRows<3>() = vee(scene.M());
  return x;
}

void RigidBodyObservables3::write(const Point& x, std::size_t index, std::span<double> out) const {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(out.data());
  switch (offer_.kinds[index]) {
    case RigidBodyField::Q:
      block = Q(x);
      if (R_) block *= R_->transpose();
      break;
    case RigidBodyField::M:
      block = hat(to_caller(m(x)));
      break;
    case RigidBodyField::Omega:
      block = hat(to_caller(omega(x)));
      break;
    case RigidBodyField::angular_velocity:
      Eigen::Map<Eigen::Vector3d>(out.data()) = to_caller(omega(x));
      break;
    case RigidBodyField::angular_velocity_space:
      Eigen::Map<Eigen::Vector3d>(out.data()) = to_space(x, omega(x));
      break;
    case RigidBodyField::momentum_space:
      Eigen::Map<Eigen::Vector3d>(out.data()) = to_space(x, m(x));
      break;
    case RigidBodyField::quaternion: {
      Eigen::Map<Eigen::Vector4d> q(out.data());
      q = x.topRows<4>();
      if (R_)
        q = Coordinates3::quaternion_times(Eigen::Vector4d(q), r_conjugate_(0),
                                           r_conjugate_.tail<3>());
    }
  }
}

void RigidBodyObservables3::invariants(const Point& x, InvariantList& out) const {
  const Eigen::Matrix3d M = hat(m(x));
  rigid_body_invariants(Side::left, lambda_, Q(x), M, out);
  if (offer_.map_step) add_discrete_hamiltonian(lambda_, M, *offer_.map_step, out);
}

std::optional<double> RigidBodyObservables3::orthogonality(const Point& x) const {
  if (!frame_) return std::nullopt;
  return orthogonality_defect(Q(x));
}

double RigidBodyObservables3::rate(const Point& x) const { return omega(x).norm(); }

auto RigidBodyObservables3::from_blocks(const Eigen::MatrixXd& blocks) const -> Point {
  Point x(frame_ ? 7 : 3, 1);
  if (frame_) x.topRows<4>() = quaternion_of(determinant_ * blocks.topRows(3));
  x.bottomRows<3>() = vee(blocks.bottomRows(3));
  return x;
}

Eigen::MatrixXd RigidBodyObservables3::to_blocks(const Point& x) const {
  const Eigen::MatrixXd frame_part = Q(x);
  Eigen::MatrixXd out(frame_part.rows() + 3, 3);
  out << frame_part, hat(m(x));
  return out;
}

Eigen::Vector3d RigidBodyObservables3::to_space(const Point& x, const Eigen::Vector3d& v) const {
  const Eigen::Vector3d product = rotation_matrix<double>(Eigen::Vector4d(x.topRows<4>())) * v;
  constexpr double most = std::numeric_limits<double>::max();
  return product.unaryExpr([](double y) { return std::isfinite(y) ? y : std::copysign(most, y); });
}

Eigen::MatrixXd RigidBodyObservables3::Q(const Point& x) const {
  if (!frame_) return Eigen::MatrixXd(0, 0);
  return determinant_ * rotation_matrix<double>(Eigen::Vector4d(x.topRows<4>()));
}

Eigen::Vector3d RigidBodyObservables3::omega(const Point& x) const {
  Coordinates3::State state = Coordinates3::State::Zero();
  state.tail<3>() = m(x);
  Eigen::Vector3d w;
  Coordinates3::inverse_inertia(lambda_, state, w);
  return w;
}

Eigen::Vector3d RigidBodyObservables3::to_caller(const Eigen::Vector3d& v) const {
  return R_ ? *R_ * v : v;
}

SharedObservables rigid_body_observables(const Scene& scene) {
  SharedObservables body = scene.dimension() == 3 ? shared(RigidBodyObservables3(scene))
                                                  : shared(RigidBodyObservables(scene));
  return system_entry(scene.system())->view ? viewed(scene, std::move(body)) : body;
}

}  // namespace stiefel
