#include "engine/methods/support/fehlberg.h"

#include <Eigen/Core>

namespace stiefel {
namespace {

template <class S>
using Coefficients = std::array<S, Fehlberg<S>::stages>;

/// The coefficients of each stage after the first, by those before it; then those of the solution
/// of order 8, and of its difference from the solution of order 7.
template <class S>
constexpr std::array<Coefficients<S>, 14> tableau = {{
    {S(2) / 27},
    {S(1) / 36, S(1) / 12},
    {S(1) / 24, 0, S(1) / 8},
    {S(5) / 12, 0, S(-25) / 16, S(25) / 16},
    {S(1) / 20, 0, 0, S(1) / 4, S(1) / 5},
    {S(-25) / 108, 0, 0, S(125) / 108, S(-65) / 27, S(125) / 54},
    {S(31) / 300, 0, 0, 0, S(61) / 225, S(-2) / 9, S(13) / 900},
    {2, 0, 0, S(-53) / 6, S(704) / 45, S(-107) / 9, S(67) / 90, 3},
    {S(-91) / 108, 0, 0, S(23) / 108, S(-976) / 135, S(311) / 54, S(-19) / 60, S(17) / 6,
     S(-1) / 12},
    {S(2383) / 4100, 0, 0, S(-341) / 164, S(4496) / 1025, S(-301) / 82, S(2133) / 4100, S(45) / 82,
     S(45) / 164, S(18) / 41},
    {S(3) / 205, 0, 0, 0, 0, S(-6) / 41, S(-3) / 205, S(-3) / 41, S(3) / 41, S(6) / 41},
    {S(-1777) / 4100, 0, 0, S(-341) / 164, S(4496) / 1025, S(-289) / 82, S(2193) / 4100, S(51) / 82,
     S(33) / 164, S(12) / 41, 0, 1},
    {0, 0, 0, 0, 0, S(34) / 105, S(9) / 35, S(9) / 35, S(9) / 280, S(9) / 280, 0, S(41) / 840,
     S(41) / 840},
    {S(-41) / 840, 0, 0, 0, 0, 0, 0, 0, 0, 0, S(-41) / 840, S(41) / 840, S(41) / 840},
}};

}  // namespace

template <class Scalar>
void Fehlberg<Scalar>::step(const Field& field, const Numbers& x, const Numbers& slope, Scalar h,
                            Numbers& next, Numbers& error) {
  const auto vector = [](auto& numbers) {
    using Plain = Eigen::Array<Scalar, Eigen::Dynamic, 1>;
    using Kept = std::conditional_t<std::is_const_v<std::remove_reference_t<decltype(numbers)>>,
                                    const Plain, Plain>;
    return Eigen::Map<Kept>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
  };
  const auto add_stages = [&](int row, Numbers& sum) {
    for (int k = 0; k < stages; ++k)
      if (const Scalar a = tableau<Scalar>[row][k]; a != 0)
        vector(sum) += (a * h) * vector(k == 0 ? slope : slopes_[k]);
  };
  next.resize(x.size());
  for (int k = 1; k < stages; ++k) {
    vector(next) = vector(x);
    add_stages(k - 1, next);
    slopes_[k].resize(x.size());
    field(next, slopes_[k]);
  }
  vector(next) = vector(x);
  add_stages(stages - 1, next);
  error.assign(x.size(), 0);
  add_stages(stages, error);
}

template class Fehlberg<double>;
template class Fehlberg<long double>;

}  // namespace stiefel
