#include <cmath>
#include <limits>

#include "engine/body/reports_3.h"
#include "engine/body/rigid_forms.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"
#include "engine/motion/body_view.h"

namespace stiefel {
namespace {

using Square = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Vector4d q(const double* x) { return Eigen::Map<const Eigen::Vector4d>(x); }

/// Q of a point that has one.
Square frame(const Body3& body, const double* x) {
  return body.determinant * rotation_matrix<double>(q(x));
}

Eigen::Vector3d omega(const Body3& body, const Eigen::Vector3d& m) {
  Eigen::Vector3d w;
  So3<double, false>::inverse_inertia(body.lambda, m, w);
  return w;
}

Eigen::Vector3d to_caller(const Body3& body, const Eigen::Vector3d& v) {
  return body.axes ? body.axes->rotation * v : v;
}

/// The vector of Q A Qᵀ in space axes for A = hat(v) in principal axes. A number that overflows is
/// the largest one, so that a state counts as finite as long as q and v are.
Eigen::Vector3d to_space(const double* x, const Eigen::Vector3d& v) {
  constexpr double most = std::numeric_limits<double>::max();
  return Eigen::Vector3d(rotation_matrix<double>(q(x)) * v).unaryExpr([](double y) {
    return std::isfinite(y) ? y : std::copysign(most, y);
  });
}

/// Q of a point; empty where the scene has none.
Dense matrix(const Body3& body, const double* x) {
  return body.has_frame ? Dense(frame(body, x)) : Dense(0, 0);
}

}  // namespace

Body3 body_3(const Scene& scene) {
  return {.lambda = scene.inertia(),
          .m = vee(body_momentum(scene)),
          .has_frame = scene.has_frame(),
          .determinant = scene.determinant(),
          .attitude = scene.attitude(),
          .axes = scene.axes()};
}

Reported3::Reported3(const Body3& body) : Body3(body) {
  if (axes) axes_quaternion = quaternion_of(axes->rotation);
}

Reports3::Reports3(const Scene& like) : has_frame_(like.has_frame()) {
  if (like.method().empty()) map_step_ = like.step();
  if (has_frame_) add(Kind::Q, {"Q", 3, 3});
  add(Kind::M, {"M", 3, 3});
  add(Kind::Omega, {"Omega", 3, 3});
  if (has_frame_ && like.determinant() == 1) add(Kind::quaternion, {"quaternion", 1, 4});
  add(Kind::angular_velocity, {"angular_velocity", 1, 3});
  if (!has_frame_) return;
  add(Kind::velocity_in_space, {"angular_velocity_space", 1, 3});
  add(Kind::momentum_in_space, {"momentum_space", 1, 3});
}

void Reports3::add(Kind kind, Field field) {
  kinds_.push_back(kind);
  fields_.push_back(std::move(field));
}

void Reports3::write(const Reported3& body, const double* x, std::size_t index,
                     std::span<double> out) const {
  const Eigen::Vector3d m(x + size() - 3);
  const auto vector = [&](const Eigen::Vector3d& v) { std::copy_n(v.data(), 3, out.data()); };
  const auto square = [&](const Square& A) { std::copy_n(A.data(), 9, out.data()); };
  switch (kinds_[index]) {
    case Kind::Q: {
      Square Q = frame(body, x);
      if (body.axes) Q *= body.axes->rotation.transpose();
      return square(Q);
    }
    case Kind::M:
      return square(hat(to_caller(body, m)));
    case Kind::Omega:
      return square(hat(to_caller(body, omega(body, m))));
    case Kind::quaternion: {
      Eigen::Vector4d at = q(x);
      if (body.axes)
        at = So3<double, true>::quaternion_times(at, body.axes_quaternion(0),
                                                 Eigen::Vector3d(-body.axes_quaternion.tail<3>()));
      std::copy_n(at.data(), 4, out.data());
      return;
    }
    case Kind::angular_velocity:
      return vector(to_caller(body, omega(body, m)));
    case Kind::velocity_in_space:
      return vector(to_space(x, omega(body, m)));
    case Kind::momentum_in_space:
      return vector(to_space(x, m));
  }
}

void Reports3::invariants(const Body3& body, const double* x, InvariantList& out) const {
  const Dense M = hat(Eigen::Vector3d(x + size() - 3));
  rigid_body_invariants(Side::left, body.lambda, matrix(body, x), M, out);
  if (map_step_) add_discrete_hamiltonian(body.lambda, M, *map_step_, out);
}

std::optional<double> Reports3::orthogonality(const Body3& body, const double* x) const {
  if (!has_frame_) return std::nullopt;
  return orthogonality_defect(matrix(body, x));
}

double Reports3::rate(const Body3& body, const double* x) const {
  return omega(body, Eigen::Vector3d(x + size() - 3)).norm();
}

}  // namespace stiefel
