#pragma once

#include "engine/linalg/lie/so_4.h"
#include "engine/rigid_body/rigid_body_observables.h"
#include "engine/stepping/stored_as.h"

namespace stiefel {

/// The coordinates of So4 as a form for StoredAs.
template <class Scalar, bool frame>
struct So4Coordinates {
  using Space = So4<Scalar, frame>;
  using Wide = Eigen::MatrixXd;  ///< Q over M
  using Point = typename Space::State;

  static Point to_stored(const Wide& x) {
    Eigen::Matrix<double, Point::RowsAtCompileTime, 1> out;
    if constexpr (frame) out.template head<16>() = x.topRows(4).reshaped();
    for (int k = 0; k < 6; ++k)
      out(Space::first + k) = x(x.rows() - 4 + skew4_rows[k], skew4_columns[k]);
    return rounded_to<Scalar>(out);
  }
  static Wide to_wide(const Point& x) {
    Wide out = Wide::Zero(frame ? 8 : 4, 4);
    if constexpr (frame) out.topRows(4).reshaped() = x.template head<16>().template cast<double>();
    for (int k = 0; k < 6; ++k) {
      const int i = skew4_rows[k], j = skew4_columns[k], top = frame ? 4 : 0;
      out(top + i, j) = x(Space::first + k);
      out(top + j, i) = -x(Space::first + k);
    }
    return out;
  }
};

/// Reads states in the coordinates of So4 as matrices Q over M.
template <class Scalar, bool frame>
auto so4_observables(const Scene& scene) {
  using Observables = RigidBodyObservables<SoN<double>>;
  return StoredAs<So4Coordinates<Scalar, frame>, Observables>(Observables(scene));
}

}  // namespace stiefel
