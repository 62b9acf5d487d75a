// The elliptic integrals and functions of the engine and of Boost.Math, in units in the last place,
// against their values in quadruple precision. exact_test.cc compares those with the definitions.

#include <gtest/gtest.h>

#include <boost/math/special_functions/ellint_rc.hpp>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <boost/math/special_functions/ellint_rj.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <iostream>
#include <random>
#include <sstream>

#include "engine/dense/carlson.h"
#include "engine/dense/jacobi_elliptic.h"
#include "engine/numbers/quadruple.h"

namespace stiefel {
namespace {

namespace policies = boost::math::policies;
/// Boost.Math computes in the scalar itself.
using InScalar = policies::policy<policies::promote_double<false>>;

template <class Scalar>
double ulps(Scalar value, Quad exact) {
  return static_cast<double>(abs((Quad(value) - exact) / exact)) /
         std::ldexp(1.0, -std::numeric_limits<Scalar>::digits);
}

/// The largest error of the engine and of Boost.Math.
struct Worst {
  double ours = 0, boosts = 0;

  template <class Scalar>
  void add(Scalar our, Scalar boost, Quad exact, double condition = 1) {
    ours = std::max(ours, ulps(our, exact) / condition);
    boosts = std::max(boosts, ulps(boost, exact) / condition);
  }
  void print(const std::string& what) const {
    std::cout << what << ": engine " << ours << " ulps, Boost.Math " << boosts << " ulps\n";
  }
};

template <class Scalar>
class SpecialFunctions : public ::testing::Test {
 protected:
  std::string name(const std::string& function) const {
    return function + (std::is_same_v<Scalar, double> ? ", double" : ", long double");
  }
  Scalar uniform() { return std::generate_canonical<Scalar, 64>(generator_); }
  /// Returns a number between 10^−decades and 10^decades.
  Scalar any(int decades) { return std::pow(Scalar(10), decades * (2 * uniform() - 1)); }

 private:
  std::mt19937_64 generator_{7};
};
using Precisions = ::testing::Types<double, long double>;
TYPED_TEST_SUITE(SpecialFunctions, Precisions);

TYPED_TEST(SpecialFunctions, CarlsonsIntegralsAreAsAccurateAsThoseOfBoost) {
  using Scalar = TypeParam;
  Worst R_C, R_F, R_J;
  for (int k = 0; k < 2000; ++k) {
    const int decades = k % 2 ? 2 : 8;
    const Scalar x = k % 4 == 0 ? Scalar(0) : this->any(decades), y = this->any(decades),
                 z = this->any(decades), p = this->any(decades);
    R_C.add(carlson::R_C<Scalar>(x, y), boost::math::ellint_rc(x, y, InScalar()),
            carlson::R_C<Quad>(x, y));
    R_F.add(carlson::R_F<Scalar>(x, y, z), boost::math::ellint_rf(x, y, z, InScalar()),
            carlson::R_F<Quad>(x, y, z));
    R_J.add(carlson::R_J<Scalar>(x, y, z, p), boost::math::ellint_rj(x, y, z, p, InScalar()),
            carlson::R_J<Quad>(x, y, z, p));
  }
  R_C.print(this->name("R_C"));
  R_F.print(this->name("R_F"));
  R_J.print(this->name("R_J"));
  for (const auto& [worst, bound] : {std::pair(R_C, 6), {R_F, 8}, {R_J, 12}}) {
    EXPECT_LT(worst.ours, bound);
    EXPECT_LT(worst.boosts, bound);
  }
}

/// Relative errors of sn, cn and dn up to 0.9 K, in units of the error that the last place of u
/// causes, which is about 1 + u.
TYPED_TEST(SpecialFunctions, JacobisFunctionsStayAccurateWhereTheModulusLosesItsDigits) {
  using Scalar = TypeParam;
  for (const double mc : {0.99, 0.5, 1e-3, 1e-8, 1e-14, 1e-30}) {
    const JacobiElliptic<Quad> exact{Quad(Scalar(mc))};
    const JacobiElliptic<Scalar> ours{Scalar(mc)};
    const Scalar k = std::sqrt(1 - Scalar(mc));
    Worst worst;
    for (int i = 0; i < 500; ++i) {
      const Scalar u = Scalar(0.9) * ours.K() * this->uniform();
      const auto [s, c, d] = exact(Quad(u));
      const auto [sn, cn, dn] = ours(u);
      Scalar boost_cn, boost_dn;
      const Scalar boost_sn = boost::math::jacobi_elliptic(k, u, &boost_cn, &boost_dn, InScalar());
      const double condition = 1 + static_cast<double>(u);
      worst.add(sn, boost_sn, s, condition);
      worst.add(cn, boost_cn, c, condition);
      worst.add(dn, boost_dn, d, condition);
    }
    std::ostringstream what;
    what << "sn, cn, dn for 1 - k^2 = " << mc;
    worst.print(this->name(what.str()));
    EXPECT_LT(worst.ours, 64) << mc;
    if (mc <= 1e-8) {
      EXPECT_GT(worst.boosts, 1e4) << mc;
    }
  }
}

}  // namespace
}  // namespace stiefel
