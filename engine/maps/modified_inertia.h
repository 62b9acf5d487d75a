#pragma once

#include <optional>

#include "engine/maps/modified_series.h"
#include "engine/maps/thin_inertia.h"

namespace stiefel {

/// The moments of ModifiedSeries, whatever those of the body: where they are spread wide by
/// ThinInertia.
template <class Wide>
class ModifiedInertia {
 public:
  using Vec = Vector3<Wide>;

  template <class Scalar>
  ModifiedInertia(const Vector<Scalar>& lambda, int order)
      : ModifiedInertia(PrincipalMoments3<Wide>(lambda), order) {
    constexpr int widest = 64;  // to the fourth power what rounding in extended precision allows
    if (widest * moments_.minCoeff() < moments_.maxCoeff())
      thin_.emplace(words(lambda.template cast<Wide>()), order);
  }

  /// J for the motion that passes through m, with the step h.
  PrincipalMoments3<Wide> operator()(const Vec& m, Wide h) const {
    if (!thin_) return series_(m, h);
    const PrincipalMoments3<Words> J = (*thin_)(words(m), words(h));
    return {number(J.moments), number(J.differences)};
  }

  /// |h||ω|.
  Wide turn(const Vec& m, Wide h) const {
    using std::abs;
    return abs(h) * m.cwiseQuotient(moments_).norm();
  }

 private:
  using Words = ThinInertia::Words;

  ModifiedInertia(const PrincipalMoments3<Wide>& body, int order)
      : moments_(body.moments), series_(body, order) {}

  static Words words(const Wide& x) {
    const auto high = static_cast<long double>(x);
    return {high, static_cast<long double>(x - Wide(high))};
  }
  static Vector3<Words> words(const Vec& x) { return {words(x(0)), words(x(1)), words(x(2))}; }
  static Vec number(const Vector3<Words>& x) {
    Vec sum;
    for (int i = 0; i < 3; ++i) sum(i) = Wide(x(i).high) + Wide(x(i).low);
    return sum;
  }

  Vec moments_;
  ModifiedSeries<Wide> series_;
  std::optional<ThinInertia> thin_;
};

}  // namespace stiefel
