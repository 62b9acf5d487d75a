#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "tests/bench/measure.h"
#include "tests/bench/peers/contestant.h"
#include "tests/support/linalg/quadruple.h"

namespace stiefel::bench {

/// Solves q̇ = ½ q∘(0, ω), I₁ω̇₁ = (I₂ − I₃)ω₂ω₃ and cyclic by Taylor series in quadruple
/// precision. The right-hand sides are quadratic, so each coefficient is a sum of products of lower
/// ones. It shares no code with any contestant.
class TaylorSeries {
  using Quad = testing::Quad;

 public:
  TaylorSeries(const Body& body, double tolerance) : I_(), tolerance_(tolerance) {
    std::copy(body.moments.begin(), body.moments.end(), I_.begin());
    q_[0][0] = 1;
    for (std::size_t i = 0; i < 3; ++i) omega_[i][0] = body.angular_velocity[i];
  }

  void advance_to(double time) {
    for (Quad left = time; left > 0;) {
      expand();
      const Quad h = std::min(left, stride());
      for (Series& x : q_) x[0] = sum(x, h);
      for (Series& x : omega_) x[0] = sum(x, h);
      left -= h;
      ++steps_;
    }
  }

  std::int64_t steps() const { return steps_; }
  End end() const {
    const auto number = [](const Series& x) { return static_cast<double>(x[0]); };
    return {{number(q_[0]), number(q_[1]), number(q_[2]), number(q_[3])},
            {number(omega_[0]), number(omega_[1]), number(omega_[2])}};
  }

 private:
  static constexpr std::size_t order = 28;
  using Series = std::array<Quad, order + 1>;

  /// Returns coefficient n of the product of two series.
  static Quad product(const Series& a, const Series& b, std::size_t n) {
    Quad sum = 0;
    for (std::size_t i = 0; i <= n; ++i) sum += a[i] * b[n - i];
    return sum;
  }

  void expand() {
    const auto& [w, x, y, z] = q_;
    const auto& [a, b, c] = omega_;
    for (std::size_t n = 0; n < order; ++n) {
      const auto times = [n](const Series& f, const Series& g) { return product(f, g, n); };
      const Quad two = 2 * Quad(n + 1), one = n + 1;
      q_[0][n + 1] = -(times(x, a) + times(y, b) + times(z, c)) / two;
      q_[1][n + 1] = (times(w, a) + times(y, c) - times(z, b)) / two;
      q_[2][n + 1] = (times(w, b) + times(z, a) - times(x, c)) / two;
      q_[3][n + 1] = (times(w, c) + times(x, b) - times(y, a)) / two;
      omega_[0][n + 1] = (I_[1] - I_[2]) / I_[0] * times(b, c) / one;
      omega_[1][n + 1] = (I_[2] - I_[0]) / I_[1] * times(c, a) / one;
      omega_[2][n + 1] = (I_[0] - I_[1]) / I_[2] * times(a, b) / one;
    }
  }

  /// Returns the step for which the last two terms of each series are below the tolerance, for ω
  /// relative to |ω|.
  Quad stride() const {
    Quad h = std::numeric_limits<double>::max();
    const auto limit = [&](const auto& all, std::size_t n) {
      Quad first = 0, last = 0;
      for (const Series& x : all) {
        first = std::max(first, abs(x[0]));
        last = std::max(last, abs(x[n]));
      }
      if (last > 0) h = std::min(h, pow(tolerance_ * first / last, 1 / Quad(n)));
    };
    for (const std::size_t n : {order - 1, order}) {
      limit(q_, n);
      limit(omega_, n);
    }
    return h;
  }

  static Quad sum(const Series& x, const Quad& h) {
    Quad value = x[order];
    for (std::size_t n = order; n-- > 0;) value = value * h + x[n];
    return value;
  }

  std::array<Quad, 3> I_;
  Quad tolerance_;
  std::array<Series, 4> q_{};
  std::array<Series, 3> omega_{};
  std::int64_t steps_ = 0;
};

inline Contestant reference() {
  return {"reference", "reference", "tolerance", "steps", [](const Task& task) {
            Answer answer{};
            for (const Body& body : task.bodies) {
              TaylorSeries series(body, task.setting);
              answer.seconds += processor_seconds([&] { series.advance_to(task.time); });
              answer.work += series.steps();
              answer.ends.push_back(series.end());
            }
            return answer;
          }};
}

}  // namespace stiefel::bench
