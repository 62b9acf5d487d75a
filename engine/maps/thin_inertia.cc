#include "engine/maps/thin_inertia.h"

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/eigen.hpp>

#include "engine/maps/modified_series.h"

namespace stiefel {
namespace {

namespace mp = boost::multiprecision;
using Number = mp::number<mp::cpp_bin_float<512, mp::digit_base_2>, mp::et_off>;
using Words = ThinInertia::Words;

Number number(const Words& x) { return Number(x.high) + Number(x.low); }
Vector3<Number> number(const Vector3<Words>& x) {
  return {number(x(0)), number(x(1)), number(x(2))};
}

Words words(const Number& x) {
  const auto high = static_cast<long double>(x);
  return {high, static_cast<long double>(Number(x - Number(high)))};
}
Vector3<Words> words(const Vector3<Number>& x) { return {words(x(0)), words(x(1)), words(x(2))}; }

}  // namespace

struct ThinInertia::Series {
  ModifiedSeries<Number> in_many_bits;
};

ThinInertia::ThinInertia(const Vector3<Words>& lambda, int order)
    : series_(std::make_shared<Series>(
          ModifiedSeries<Number>(PrincipalMoments3<Number>(number(lambda)), order))) {}

PrincipalMoments3<Words> ThinInertia::operator()(const Vector3<Words>& m, const Words& h) const {
  const PrincipalMoments3<Number> J = series_->in_many_bits(number(m), number(h));
  return {words(J.moments), words(J.differences)};
}

}  // namespace stiefel
