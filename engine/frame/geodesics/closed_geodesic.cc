#include <cmath>
#include <numbers>

#include "engine/dense/carlson.h"
#include "engine/frame/geodesics/geodesic_search.h"

namespace stiefel {
namespace {

using Wide = long double;
constexpr Wide half_turn = std::numbers::pi_v<Wide>;

/// The circle q = a cos φ + b sin φ, where a and b are the axes of the smaller and of the larger λ,
/// whose lengths are ∫ w dφ, w² = cos²φ + r sin²φ, in units of √λ.
class Circle {
 public:
  Circle(const VectorXd& lambda, bool body)
      : large_(lambda(1) >= lambda(0) ? 1 : 0),
        r_(body ? Wide(1) : lambda(1 - large_) / Wide(lambda(large_))) {}

  Found shortest(const MatrixXd& Q_0, const MatrixXd& Q_T) const {
    const Wide a = Q_0(0, 1 - large_), b = Q_0(0, large_), a_T = Q_T(0, 1 - large_),
               b_T = Q_T(0, large_);
    const Wide phi = std::atan2(b, a), turn = std::atan2(a * b_T - b * a_T, a * a_T + b * b_T);
    const Wide direct = length(phi + turn) - length(phi), round = 4 * quarter(1);
    const bool other = std::abs(direct) > round / 2;
    const Wide way = other ? direct - std::copysign(round, direct) : direct;
    const Wide rate = way / std::sqrt(a * a + r_ * b * b);
    MatrixXd J(2, 2);  // qJ is dq/dφ
    J.setZero();
    J(1 - large_, large_) = 1;
    J(large_, 1 - large_) = -1;
    return {static_cast<double>(rate) * Q_0 * J, Shortest::yes, 2, other ? 1 : 0};
  }

 private:
  /// Returns ∫ w dφ from 0 to φ.
  Wide length(Wide phi) const {
    const Wide halves = std::round(phi / half_turn);
    return 2 * halves * quarter(1) + quarter(std::sin(phi - halves * half_turn));
  }

  /// Returns the integral for |φ| ≤ π/2, s = sin φ, in terms that are all positive (DLMF 19.25.10).
  Wide quarter(Wide s) const {
    const Wide c2 = (1 - s) * (1 + s), w2 = c2 + r_ * s * s, k2 = 1 - r_;
    const Wide F = s * carlson::R_F<Wide>(c2, w2, 1),
               D = s * s * s * carlson::R_J<Wide>(c2, 1, w2, w2) / 3;
    return r_ * (F + k2 * D) + k2 * s * std::sqrt(c2 / w2);
  }

  int large_;  ///< index of the larger λ
  Wide r_;     ///< smaller λ / larger λ; 1 for n = 2, where every angle has the same length
};

/// Returns the angle from Q_0 to Q_T times a unit tangent vector. Next to the antipode the tangent
/// vector is that of Q_T + Q_0, whose digits are not lost in a difference.
MatrixXd great_circle(const MatrixXd& Q_0, const MatrixXd& Q_T) {
  const double angle = 2 * std::atan2((Q_T - Q_0).norm(), (Q_T + Q_0).norm());
  const double sign = Q_0.row(0).dot(Q_T.row(0)) < 0 ? -1 : 1;
  const MatrixXd chord = Q_T - sign * Q_0;
  const auto projected = [&](const MatrixXd& v) -> MatrixXd {
    return v - v.row(0).dot(Q_0.row(0)) * Q_0;
  };
  MatrixXd tangent = projected(chord);
  constexpr double rounding = 1e-15;  // a chord so short has no direction
  if (tangent.norm() < rounding) tangent = complement(Q_0).topRows(1);
  tangent = projected(tangent.normalized()).normalized();
  return angle * tangent;
}

}  // namespace

bool is_round(const VectorXd& lambda) {
  return lambda.maxCoeff() - lambda.minCoeff() <= 1e-15 * lambda.maxCoeff();
}

std::optional<Found> closed_geodesic(const VectorXd& lambda, const MatrixXd& Q_0,
                                     const MatrixXd& Q_T) {
  const bool body = Q_0.rows() == Q_0.cols();
  if (Q_0.cols() == 2) return Circle(lambda, body).shortest(Q_0, Q_T);
  if (!is_round(lambda)) return {};
  if (Q_0.rows() == 1) return Found{great_circle(Q_0, Q_T), Shortest::yes, 1, 0};
  if (!body) return {};
  return Found{Q_0 * PlaneRotations(Q_0.transpose() * Q_T).logarithm(), Shortest::yes, 1, 0};
}

}  // namespace stiefel
