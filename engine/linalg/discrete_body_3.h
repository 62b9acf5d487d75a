#pragma once

#include <cmath>

#include "engine/linalg/cayley_3.h"
#include "engine/linalg/compensated.h"
#include "engine/linalg/principal_moments_3.h"
#include "engine/linalg/so_3.h"

namespace stiefel {

/// Principal moments and a step, with what the discrete body makes of them.
template <class Scalar>
struct DiscreteInertia3 : PrincipalMoments3<Extended<Scalar>> {
  using Wide = Extended<Scalar>;
  using Moments = PrincipalMoments3<Wide>;

  Scalar h;
  bool positive;
  Vector3<Scalar> half_turn;  ///< (h/2)/I
  Vector3<Scalar> kappa;      ///< (I₂ − I₃)/I₁ and cyclic
  Vector3<Scalar> gain;       ///< (4/h)(I₂ − I₃) and cyclic

  DiscreteInertia3(const Moments& I, Scalar step)
      : Moments(I),
        h(step),
        positive(I.moments.minCoeff() > Wide(0)),
        half_turn((Wide(step) / 2 * I.moments.cwiseInverse()).template cast<Scalar>()),
        kappa(I.differences.cwiseQuotient(I.moments).template cast<Scalar>()),
        gain((4 / Wide(step) * I.differences).template cast<Scalar>()) {}
};

/// One step of the discrete rigid body of Moser and Veselov in three dimensions, on (q; m) or m
/// alone: U = J_D⁻¹(hM) as the Cayley transform U = (I − ĉ)⁻¹(I + ĉ), then Q ← QU and M ← UᵀMU,
///
///     q ← q∘(1, c)/|(1, c)|,   m₁ ← m₁ + (4/h)(I₂ − I₃) c₂c₃/(1 + |c|²) and cyclic.
///
/// It divides by no λ_i, so thin plates are bodies like others. Whatever constant positive moments
/// it is given, it keeps |m|², Σ m_i²/I_i and Q m.
template <class Scalar, bool frame, Arithmetic arithmetic>
class DiscreteBody3 {
 public:
  using Point = typename So3<Scalar, frame>::State;
  using State = Accumulator<Point, arithmetic>;
  using Wide = Extended<Scalar>;
  using Inertia = DiscreteInertia3<Scalar>;

  /// Finds c; false where there is none.
  bool solve(const State& x, const Inertia& I) {
    return I.positive && equation_.solve(n(x, I), I.kappa) && on_branch(x, I, I.h);
  }
  /// The same for the step t·h, from the solution found last.
  bool continue_to(const State& x, const Inertia& I, Scalar t = 1) {
    const Vector3<Scalar> found = equation_.c;
    if (I.positive && equation_.newton(t * n(x, I), I.kappa) && on_branch(x, I, t * I.h))
      return true;
    equation_.c = found;
    return false;
  }
  void restart() { equation_.c.setZero(); }

  /// The step with the c that was found.
  void transport(State& x, const Inertia& I) const {
    if constexpr (arithmetic == Arithmetic::plain)
      transport_plain(x.value, I);
    else
      transport_compensated(x, I);
  }

 private:
  static constexpr int first = frame ? 4 : 0;  // of m

  static Vector3<Scalar> m(const State& x) { return x.value.template tail<3>(); }
  static Vector3<Scalar> n(const State& x, const Inertia& I) {
    return I.half_turn.cwiseProduct(m(x));
  }

  /// With I∘c − (h/2)(m + m×c + (c·m) c) = 0, another form of the equation, whose derivative has
  /// the eigenvalues w_i + w_j, w = spec(UΛ): they keep positive real parts as long as the branch
  /// that starts at the identity lasts. Routh–Hurwitz.
  bool on_branch(const State& x, const Inertia& I, Scalar h) const {
    const Vector3<Scalar>& c = equation_.c;
    if (c.squaredNorm() < Scalar(1)) return true;
    Eigen::Matrix<Scalar, 3, 3> F = (-h / 2) * (hat(m(x)) + c * m(x).transpose());
    F.diagonal() += I.moments.template cast<Scalar>();
    F.diagonal().array() -= (h / 2) * c.dot(m(x));
    F /= static_cast<Scalar>(I.moments.maxCoeff());  // its cube is a number in all units
    const Scalar trace = F.trace(), determinant = F.determinant();
    const Scalar minors = (trace * trace - (F * F).trace()) / 2;
    return trace > 0 && determinant > 0 && trace * minors > determinant;
  }

  void transport_plain(Point& x, const Inertia& I) const {
    using std::sqrt;
    const Vector3<Scalar>& c = equation_.c;
    const Scalar w = 1 / (1 + c.squaredNorm());
    x.template tail<3>() += w * I.gain.cwiseProduct(cyclic_product<Scalar>(c, c));
    if constexpr (frame) {
      const Eigen::Matrix<Scalar, 4, 1> q = So3<Scalar, true>::quaternion_times(x, Scalar(1), c);
      // |q|^−1 by one Newton step from √w, which it is but for rounding.
      x.template head<4>() = (sqrt(w) * (3 - w * q.squaredNorm()) / 2) * q;
    }
  }

  void transport_compensated(State& x, const Inertia& I) const {
    using std::sqrt;
    const Vector3<Wide> c = solution(x, I);
    const Wide c2 = c.squaredNorm(), w = 1 / (1 + c2);
    if constexpr (frame) {
      const Wide s = sqrt(w);
      const Eigen::Matrix<Wide, 7, 1> wide = x.value.template cast<Wide>();
      const auto dq =
          So3<Wide, true>::quaternion_times(wide, -c2 * w / (1 + s), Vector3<Wide>(s * c));
      for (int i = 0; i < 4; ++i) x.add(i, 0, dq(i));
    }
    const Vector3<Wide> dm = (4 * w / I.h) * I.differences.cwiseProduct(cyclic_product<Wide>(c, c));
    for (int i = 0; i < 3; ++i) x.add(first + i, 0, dm(i));
  }

  /// c after a last correction whose residual is formed in wider arithmetic.
  Vector3<Wide> solution(const State& x, const Inertia& I) const {
    Vector3<Wide> c = equation_.c.template cast<Wide>();
    const Vector3<Wide> wide_m(x.extended(first), x.extended(first + 1), x.extended(first + 2));
    const Vector3<Wide> F = I.moments.cwiseProduct(c) -
                            I.differences.cwiseProduct(cyclic_product<Wide>(c, c)) -
                            (1 + c.squaredNorm()) * (Wide(I.h) / 2) * wide_m;
    const Vector3<Scalar> G =
        (F / (Wide(I.h) / 2)).template cast<Scalar>().cwiseProduct(I.half_turn);
    c -= equation_.correction(G).template cast<Wide>();
    return c;
  }

  CayleyEquation3<Scalar> equation_;
};

}  // namespace stiefel
