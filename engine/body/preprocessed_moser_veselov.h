#pragma once

#include "engine/body/modified_series.h"
#include "engine/body/moser_veselov.h"

namespace stiefel {

/// Solves U = J_D⁻¹(hM) with the modified moments J of ModifiedSeries in place of the moments of Λ,
/// with the interface of JDInverse3. `Memory` holds the J of a motion.
template <class Scalar, bool frame>
class ModifiedJDInverse3 {
 public:
  using Body = DiscreteBody3<Scalar, frame>;
  using Point = typename Body::Point;
  using State = typename Body::State;
  struct Memory : DiscreteInertia3<Scalar>, NoMemory {};

  ModifiedJDInverse3(const Vector<Scalar>& lambda, Scalar h, int order, bool moves_frame = true)
      : h_(h), order_(order), given_(lambda), of_series_(given_), body_(moves_frame) {}

  /// Returns the J of the motion through x. Marks J as not positive where the branch of U from the
  /// identity ends at a shorter step t·h, t < 1: J(t·h) varies with t, and a U beyond a gap without
  /// solutions is not a step. Where the branch ends depends only on |m|² and the energy, so the m
  /// at the start decides for the whole motion. In tests the branch ended at h|ω| ≥ 1.4, also for
  /// rods and plates.
  Memory memory(const Point& x) const {
    const Series series = through(x);
    Memory whole = at(series, 1);
    if ((h_ / of_series_.unit * m(x).cwiseProduct(of_series_.over_I)).squaredNorm() <= 1)
      return whole;  // h|ω| ≤ 1
    Body body;
    const State first(x, Arithmetic::plain);
    const auto solve = [&](double t) { return body.continue_to(first, at(series, t)); };
    whole.positive = whole.positive && !(continuation(1, solve, longest_stride(x)) < 1);
    return whole;
  }

  bool solve(const State& x, const Memory& J) { return body_.solve(x, J); }
  /// Finds U for the step t·h, starting from the solution found last. J tends to I as t → 0.
  bool continue_to(const State& x, double t) {
    return body_.continue_to(x, at(through(x.value), t));
  }
  /// Returns the longest stride in t with which the continuation does not jump over a gap.
  double longest_stride(const Point& x) const { return 1 / (32 * turn(x)); }
  void restart() { body_.restart(); }
  void transport(State& x, const Memory& J) const { body_.transport(x, J); }

 private:
  using Wide = Extended<Scalar>;
  using Series = ModifiedSeries<Wide>;

  static Vector3<Wide> m(const Point& x) { return x.template tail<3>().template cast<Wide>(); }
  Series through(const Point& x) const { return Series(of_series_, m(x), order_); }
  Memory at(const Series& series, double t) const {
    const Scalar h = static_cast<Scalar>(t) * h_;
    return {{series(h), h}, {}};
  }
  /// Returns h|ω|.
  double turn(const Point& x) const {
    using std::abs;
    return static_cast<double>(abs(h_) * m(x).cwiseQuotient(given_.moments).norm());
  }

  Scalar h_;
  int order_;
  PrincipalMoments3<Wide> given_;
  BodyOfSeries<Wide> of_series_;
  Body body_;
};

/// The discrete rigid body of Moser and Veselov in three dimensions with modified moments J, for
/// which it approximates the continuous body to an even order (Hairer and Vilmart 2006). The map
/// keeps Σ m_i² and Σ m_i²/J_i, hence the energy of the body, because 1/J_i = s/I_i + d. It is
/// symplectic to its order: J depends on |m| and the energy, so that the two-form changes by
/// O(h^(p+1)) in a step, in proportion to the steps. J belongs to the motion: it follows from the
/// state at step 0, and stays constant.
template <class Scalar, bool frame>
using PreprocessedMoserVeselov =
    MoserVeselov<So3<Scalar, frame>, ModifiedJDInverse3<Scalar, frame>>;

}  // namespace stiefel
