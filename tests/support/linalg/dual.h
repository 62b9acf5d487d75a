#pragma once

#include <Eigen/Core>
#include <cmath>

namespace stiefel::testing {

/// A dual number a + bε, ε² = 0, which carries its exact derivative along.
struct Dual {
  double value = 0, rate = 0;

  Dual() = default;
  Dual(double v, double r = 0) : value(v), rate(r) {}  // NOLINT: numbers are duals too

  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }
  Dual operator-() const { return {-value, -rate}; }

  friend Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.rate + b.rate};
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.rate - b.rate};
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.rate + a.rate * b.value};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double q = a.value / b.value;
    return {q, (a.rate - q * b.rate) / b.value};
  }
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend auto operator<=>(const Dual& a, const Dual& b) { return a.value <=> b.value; }
  friend Dual abs(const Dual& a) { return a.value < 0 ? -a : a; }
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value);
    return {root, a.rate / (2 * root)};
  }
};

}  // namespace stiefel::testing

template <>
struct Eigen::NumTraits<stiefel::testing::Dual> : Eigen::NumTraits<double> {
  using Real = stiefel::testing::Dual;
  using NonInteger = stiefel::testing::Dual;
  using Nested = stiefel::testing::Dual;
  using Literal = double;
  enum { IsComplex = 0, RequireInitialization = 1, ReadCost = 2, AddCost = 2, MulCost = 6 };
};

namespace stiefel::testing {

/// Returns x + ε dx.
inline Eigen::Matrix<Dual, Eigen::Dynamic, Eigen::Dynamic> dual(const Eigen::MatrixXd& x,
                                                                const Eigen::MatrixXd& dx) {
  return x.binaryExpr(dx, [](double value, double rate) { return Dual(value, rate); });
}

}  // namespace stiefel::testing
