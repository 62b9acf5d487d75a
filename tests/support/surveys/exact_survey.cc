#include "tests/support/surveys/exact_survey.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/body/exact/top_in_time.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/methods/exact.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/scenes/random_top.h"

namespace stiefel::testing {
namespace {

using BodyInQuad = RigidBody<So3<Quad, true>>;
using QuadState = BodyInQuad::State;

EulerTop<Quad> motion(const RandomTop& top) {
  return {PrincipalMoments3<Quad>(top.lambda), top.x.cast<Quad>()};
}

/// Returns the distance of two states, of q and of m each relative to its norm.
double distance(const QuadState& a, const QuadState& b) {
  const Quad q = (a - b).head<4>().norm() / b.head<4>().norm();
  const Quad size = b.tail<3>().norm();
  const Quad m = size > 0 ? Quad((a - b).tail<3>().norm() / size) : Quad(a.tail<3>().norm());
  return static_cast<double>(q > m ? q : m);
}

/// Returns the distance of the vector field from a difference quotient of order 6, relative to the
/// rate.
double field_error(const RandomTop& top, const EulerTop<Quad>& exact) {
  BodyInQuad body(top.lambda.cast<Quad>());
  const Quad t = top.t;
  QuadState field;
  body.field(exact.at(t), field);
  const QuadState at = exact.at(t);
  const Quad rate = 2 * field.head<4>().norm() / at.head<4>().norm();
  if (rate == 0) return distance(at, exact.at(0));
  const Quad d = Quad(1e-4) / rate;
  const auto difference = [&](int k) {
    return QuadState((exact.at(t + k * d) - exact.at(t - k * d)) / (60 * d));
  };
  const QuadState slope = 45 * difference(1) - 9 * difference(2) + difference(3);
  QuadState error = (slope - field) / rate;
  error.tail<3>() /= at.tail<3>().norm();
  return static_cast<double>(error.norm());
}

/// Returns the change of the solution when each input changes by one ulp.
double one_ulp_of_input(const RandomTop& top, const QuadState& x) {
  double sum = 0;
  const auto add = [&](auto change) {
    RandomTop moved = top;
    change(moved);
    sum += distance(motion(moved).at(top.t), x);
  };
  for (int i = 0; i < 3; ++i) {
    add([&](RandomTop& to) { to.lambda(i) *= 1 + std::numeric_limits<double>::epsilon(); });
    add([&](RandomTop& to) { to.x(4 + i) *= 1 + std::numeric_limits<double>::epsilon(); });
  }
  return sum;
}

}  // namespace

void survey_exact(unsigned first, unsigned count) {
  for (unsigned seed = first; seed < first + count; ++seed) {
    const RandomTop top(seed);
    const EulerTop<Quad> exact = motion(top);
    EXPECT_LT(distance(exact.at(0), top.x.cast<Quad>()), 1e-31) << top.kind << " " << seed;
    const double field = field_error(top, exact);
    EXPECT_LT(field, 1e-23 * top.one_and_angle()) << top.kind << " " << seed;

    TopInTime exact_in_double(PrincipalMoments3<Number128>(top.lambda), top.x.cast<long double>());
    const QuadState x = exact.at(top.t);
    const double ulp = 0x1p-52;
    const double error = distance(exact_in_double.at(1, top.t).cast<Quad>(), x);
    double bound = ulp;
    if (!exact_in_double.theta()) {
      bound = ulp * top.one_and_angle();
      if (top.near_separatrix() && top.kind != "on the separatrix")
        bound += one_ulp_of_input(top, x);
    }
    EXPECT_LE(error, bound) << top.kind << " " << seed;
  }
}

}  // namespace stiefel::testing
