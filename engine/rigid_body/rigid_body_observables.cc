#include "engine/rigid_body/rigid_body_observables.h"

#include "engine/linalg/lie/orthogonal.h"
#include "engine/rigid_body/rigid_body_invariants.h"

namespace stiefel {

RigidBodyFields::RigidBodyFields(const Scene& scene) {
  const int N = scene.dimension();
  const auto offer = [this](const char* name, RigidBodyField kind, int rows, int cols) {
    fields.push_back({name, rows, cols});
    kinds.push_back(kind);
  };
  if (scene.has_frame()) offer("Q", RigidBodyField::Q, N, N);
  offer("M", RigidBodyField::M, N, N);
  block_count = fields.size();
  offer("Omega", RigidBodyField::Omega, N, N);
  if (N == 3 && scene.has_frame() && scene.determinant() == 1)
    offer("quaternion", RigidBodyField::quaternion, 1, 4);
  if (N == 3) offer("angular_velocity", RigidBodyField::angular_velocity, 1, 3);
  if (scene.method().empty()) map_step = scene.step();
}

template <class Space>
RigidBodyObservables<Space>::RigidBodyObservables(const Scene& scene)
    : offered_(scene), lambda_(scene.inertia()), N_(scene.dimension()) {}

template <class Space>
auto RigidBodyObservables<Space>::start(const Scene& scene) const -> Point {
  Point x(scene.Q().rows() + N_, N_);
  if (x.rows() > N_) x.topRows(N_) = scene.Q();
  x.bottomRows(N_) = scene.M();
  return x;
}

template <class Space>
void RigidBodyObservables<Space>::invariants(const Point& x, InvariantList& out) const {
  rigid_body_invariants(Side::left, lambda_, x.topRows(x.rows() - N_), x.bottomRows(N_), out);
  if (offered_.map_step)
    add_discrete_hamiltonian(lambda_, x.bottomRows(N_), *offered_.map_step, out);
}

template <class Space>
std::optional<double> RigidBodyObservables<Space>::orthogonality(const Point& x) const {
  if (x.rows() == N_) return std::nullopt;
  return orthogonality_defect(x.topRows(N_));
}

template <class Space>
double RigidBodyObservables<Space>::rate(const Point& x) const {
  return angular_velocity_norm(lambda_, x.bottomRows(N_));
}

template <class Space>
void RigidBodyObservables<Space>::write(const Point& x, std::size_t index,
                                        std::span<double> out) const {
  Eigen::Map<RowMatrix> block(out.data(), N_, N_);
  switch (offered_.kinds[index]) {
    case RigidBodyField::Q:
      block = x.topRows(N_);
      break;
    case RigidBodyField::M:
      block = x.bottomRows(N_);
      break;
    default: {
      typename Space::Algebra Omega(N_, N_);
      Space::inverse_inertia(lambda_, x, Omega);
      block = Omega;
    }
  }
}

template <bool frame>
RigidBodyObservables<So3<double, frame>>::RigidBodyObservables(const Scene& scene)
    : offered_(scene), lambda_(scene.inertia()), determinant_(scene.determinant()) {
  if (!scene.axes()) return;
  R_ = scene.axes()->rotation;
  r_conjugate_ = quaternion_of(*R_);
  r_conjugate_.tail<3>() = -r_conjugate_.tail<3>();
}

template <bool frame>
auto RigidBodyObservables<So3<double, frame>>::start(const Scene& scene) const -> Point {
  Point x;
  if constexpr (frame) x.template head<4>() = scene.attitude();
  x.template tail<3>() = vee(scene.M());
  return x;
}

template <bool frame>
auto RigidBodyObservables<So3<double, frame>>::point(const Eigen::MatrixXd& stacked) const
    -> Point {
  Point x;
  if constexpr (frame) x.template head<4>() = quaternion_of(determinant_ * stacked.topRows(3));
  x.template tail<3>() = vee(stacked.bottomRows(3));
  return x;
}

template <bool frame>
Eigen::MatrixXd RigidBodyObservables<So3<double, frame>>::stacked(const Point& x) const {
  const Eigen::MatrixXd frame_part = Q(x);
  Eigen::MatrixXd out(frame_part.rows() + 3, 3);
  out << frame_part, hat(x.template tail<3>());
  return out;
}

template <bool frame>
void RigidBodyObservables<So3<double, frame>>::invariants(const Point& x,
                                                          InvariantList& out) const {
  const Eigen::Matrix3d M = hat(x.template tail<3>());
  rigid_body_invariants(Side::left, lambda_, Q(x), M, out);
  if (offered_.map_step) add_discrete_hamiltonian(lambda_, M, *offered_.map_step, out);
}

template <bool frame>
std::optional<double> RigidBodyObservables<So3<double, frame>>::orthogonality(
    const Point& x) const {
  if constexpr (frame) return orthogonality_defect(Q(x));
  return std::nullopt;
}

template <bool frame>
double RigidBodyObservables<So3<double, frame>>::rate(const Point& x) const {
  return omega(x).norm();
}

template <bool frame>
void RigidBodyObservables<So3<double, frame>>::write(const Point& x, std::size_t index,
                                                     std::span<double> out) const {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(out.data());
  switch (offered_.kinds[index]) {
    case RigidBodyField::Q:
      if constexpr (frame) {
        block = determinant_ * rotation_matrix<double>(x.template head<4>());
        if (R_) block *= R_->transpose();
      }
      break;
    case RigidBodyField::M:
      block = hat(to_caller(x.template tail<3>()));
      break;
    case RigidBodyField::Omega:
      block = hat(to_caller(omega(x)));
      break;
    case RigidBodyField::angular_velocity:
      Eigen::Map<Eigen::Vector3d>(out.data()) = to_caller(omega(x));
      break;
    case RigidBodyField::quaternion:
      if constexpr (frame) {
        Eigen::Map<Eigen::Vector4d> q(out.data());
        q = x.template head<4>();
        if (R_) q = Space::quaternion_times(x, r_conjugate_(0), r_conjugate_.tail<3>());
      }
      break;
  }
}

template <bool frame>
Eigen::MatrixXd RigidBodyObservables<So3<double, frame>>::Q(const Point& x) const {
  if constexpr (frame) return determinant_ * rotation_matrix<double>(x.template head<4>());
  return Eigen::MatrixXd(0, 0);
}

template <bool frame>
Eigen::Vector3d RigidBodyObservables<So3<double, frame>>::omega(const Point& x) const {
  Eigen::Vector3d w;
  Space::inverse_inertia(lambda_, x, w);
  return w;
}

template <bool frame>
Eigen::Vector3d RigidBodyObservables<So3<double, frame>>::to_caller(
    const Eigen::Vector3d& v) const {
  return R_ ? *R_ * v : v;
}

template class RigidBodyObservables<SoN<double>>;
template class RigidBodyObservables<So3<double, true>>;
template class RigidBodyObservables<So3<double, false>>;

}  // namespace stiefel
