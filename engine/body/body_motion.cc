#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/body/exact/sorted_top.h"
#include "engine/dense/carlson.h"
#include "engine/dense/jacobi_elliptic.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"
#include "engine/motion/representation.h"
#include "engine/motion/system_entry.h"
#include "stiefel/diagnosis.h"

namespace stiefel {
namespace {

using Wide = long double;
using Vec = Vector3<Wide>;

constexpr Wide two_pi = 2 * std::numbers::pi_v<Wide>;

/// Returns the moment about the axis about which the body turns steadily; 0 if it does not. Squares
/// of parts of the unit momentum below 1e-28 count as rounding.
Wide steady_moment(const Vec& I, const Vec& squares) {
  Wide found = 0;
  for (int a = 0; a < 3; ++a) {
    if (squares(a) <= 1e-28L) continue;
    if (found != 0 && I(a) != found) return 0;
    found = I(a);
  }
  return found;
}

/// Adds kind, periods and nutation, in units of 1/|m|. `top` has |m| = 1.
void add_periods(const SortedTop<Wide>& top, BodyMotion& out) {
  const Vec &I = top.I, squares = top.m.cwiseAbs2();
  const Wide I_21 = top.difference(1, 0), I_32 = top.difference(2, 1), I_31 = I_21 + I_32;
  // G² − 2E I₁, 2E I₃ − G² and G² − 2E I₂: sums without cancellation but in the last.
  const Wide below = top.Delta(0), above = -top.Delta(2), side = top.Delta(1);
  if (const Wide moment = steady_moment(I, squares);
      moment != 0 && (above <= 0 || below <= 0 || side == 0)) {
    out.kind = BodyMotion::Kind::steady;
    out.separatrix = side != 0;
    out.precession_period = static_cast<double>(two_pi * moment);
    return;
  }
  if (side == 0) {
    out.kind = BodyMotion::Kind::separatrix;
    out.precession_period = static_cast<double>(two_pi * I(1));
    out.nutation[1] = std::numbers::pi / 2;
    return;
  }
  const bool short_axis = side > 0;
  out.kind = short_axis ? BodyMotion::Kind::short_axis : BodyMotion::Kind::long_axis;
  // m₂² / (m₂² + m₃²) = c sn²u / (1 − n sn²u), u = λt, with the axis 1 of the least moment; mc is
  // 1 − k².
  const Wide scale = short_axis ? I_32 * below : I_21 * above;
  const Wide n = short_axis ? -I(0) * above / (I(2) * below) : -I(0) * I_32 / (I(2) * I_21);
  const Wide c =
      short_axis ? I(1) * above * I_31 / (I_32 * I(2) * below) : I(1) * I_31 / (I(2) * I_21);
  const Wide mc = top.complementary_parameter();
  const Wide K = JacobiElliptic<Wide>(mc).K();
  out.separatrix = static_cast<double>(mc);
  out.period = static_cast<double>(4 * K * std::sqrt(I(0) * I(1) * I(2) / scale));
  // ⟨sn² / (1 − n sn²)⟩ = (Π(n) − K) / (nK) = R_J(0, mc, 1, 1 − n) / (3K).
  const Wide mean = c * carlson::R_J<Wide>(0, mc, 1, 1 - n) / (3 * K);
  out.precession_period = static_cast<double>(two_pi / (1 / I(2) + I_32 / (I(1) * I(2)) * mean));
  // The cosines of the angles are extreme where m₂ = 0 and where m₂² is largest.
  const Wide x = squares(0), y = squares(1), z = squares(2);
  const Wide first =
      short_axis ? x + y * I(0) * I_32 / (I(1) * I_31) : z + y * I(2) * I_21 / (I(1) * I_31);
  const Wide last = short_axis ? x + y + x * I(2) * I_21 / (I(0) * I_32)
                               : y + z + z * I(0) * I_32 / (I(2) * I_21);
  const auto angle = [](Wide sine_squared) {
    return static_cast<double>(std::asin(std::sqrt(std::min(sine_squared, Wide{1}))));
  };
  out.nutation = {angle(first), angle(last)};
}

}  // namespace

std::optional<BodyMotion> body_motion(const Scene& scene) {
  const SystemEntry& entry = *system_entry(scene.system());
  if (!scene.members().empty() || entry.info.velocity.empty() || scene.dimension() != 3)
    return std::nullopt;
  Margins margins;
  const auto phase = entry.representation->read(scene, margins);
  if (!phase || phase->M.rows() != 3) return std::nullopt;
  const PrincipalMoments3<Wide> body(phase->lambda);
  const Vec given = vee(phase->M).cast<Wide>();
  const Wide G = std::sqrt(given.squaredNorm());
  const SortedTop<Wide> top(body, G > 0 ? Vec(given / G) : given);

  BodyMotion out;
  const Eigen::Matrix3d turn = scene.axes() ? scene.axes()->rotation : Eigen::Matrix3d::Identity();
  for (int a = 0; a < 3; ++a) out.axes.col(a) = turn.col(top.axis[static_cast<std::size_t>(a)]);
  if (out.axes.determinant() < 0) out.axes.col(2) *= -1;
  const Eigen::MatrixXd& Q = phase->Q;
  out.momentum = Q.size() > 0 ? Eigen::Vector3d(vee((Q * phase->M * Q.transpose()).eval()))
                              : Eigen::Vector3d(turn * vee(phase->M));
  out.moments = top.I.cast<double>();
  out.energy = static_cast<double>(given.cwiseAbs2().cwiseQuotient(body.moments).sum() / 2);
  if (G == 0) return out;
  add_periods(top, out);
  const auto divide = [G](std::optional<double>& time) {
    if (time) time = static_cast<double>(*time / G);
  };
  divide(out.period);
  divide(out.precession_period);
  return out;
}

}  // namespace stiefel
