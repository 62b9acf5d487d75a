#include "engine/methods/fehlberg.h"

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

/// Sets `sum` to `from`, or 0 where there is none, plus h times the slopes by a row of the tableau.
/// The terms are unrolled, and eight numbers are summed together.
template <std::size_t row, class Scalar>
void add_stages(const std::array<const Scalar*, Fehlberg<Scalar>::stages>& slopes, Scalar h,
                const Scalar* from, Scalar* sum, std::size_t size) {
  const auto add = [&]<int count>(std::size_t i) {
    using Few = Eigen::Array<Scalar, count, 1>;
    Few numbers = Few::Zero();
    if (from != nullptr) numbers = Eigen::Map<const Few>(from + i);
    const auto term = [&]<std::size_t k>() {
      if constexpr (constexpr Scalar a = tableau<Scalar>[row][k]; a != 0)
        numbers += (a * h) * Eigen::Map<const Few>(slopes[k] + i);
    };
    [&]<std::size_t... k>(std::index_sequence<k...>) { (term.template operator()<k>(), ...); }
    (std::make_index_sequence<Fehlberg<Scalar>::stages>());
    Eigen::Map<Few>(sum + i) = numbers;
  };
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) add.template operator()<8>(i);
  for (; i + 2 <= size; i += 2) add.template operator()<2>(i);
  if (i < size) add.template operator()<1>(i);
}

}  // namespace

template <class Scalar>
void Fehlberg<Scalar>::step(const Field& field, const Numbers& x, const Numbers& slope, Scalar h,
                            Numbers& next, Numbers& error) {
  next.resize(x.size());
  error.resize(x.size());
  std::array<const Scalar*, stages> slopes = {slope.data()};
  for (int k = 1; k < stages; ++k) {
    slopes_[k].resize(x.size());
    slopes[k] = slopes_[k].data();
  }
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    ((add_stages<k>(slopes, h, x.data(), next.data(), x.size()), field(next, slopes_[k + 1])), ...);
  }
  (std::make_index_sequence<stages - 1>());
  add_stages<stages - 1>(slopes, h, x.data(), next.data(), x.size());
  add_stages<stages>(slopes, h, static_cast<const Scalar*>(nullptr), error.data(), x.size());
}

template class Fehlberg<double>;

}  // namespace stiefel
