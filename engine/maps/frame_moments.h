#pragma once

#include <array>

#include "engine/linalg/scalar.h"

namespace stiefel {

/// All that a step has to know of a state on V(n, N): the n × n sums over its N columns, with V =
/// Q̇ = SΛ⁻¹,
///
///     QQ[p] = QΛ⁻ᵖQᵀ, p = 0..3,   QV[p] = QΛ⁻ᵖVᵀ, p = 0..2,   VV[p] = VΛ⁻ᵖVᵀ, p = 0, 1.
template <class Scalar, int n = Eigen::Dynamic>
struct FrameMoments {
  using Sum = Eigen::Matrix<Scalar, n, n>;
  std::array<Sum, 4> QQ;
  std::array<Sum, 3> QV;
  std::array<Sum, 2> VV;

  explicit FrameMoments(Eigen::Index rows) {
    each([rows](Sum& sum) { sum.setZero(rows, rows); });
  }

  template <class Visitor>
  void each(Visitor&& visit) {
    for (Sum& sum : QQ) visit(sum);
    for (Sum& sum : QV) visit(sum);
    for (Sum& sum : VV) visit(sum);
  }

  void set_zero() {
    each([](Sum& sum) { sum.setZero(); });
  }

  template <int other>
  void assign(const FrameMoments<Scalar, other>& moments) {
    for (std::size_t p = 0; p < 4; ++p) QQ[p] = moments.QQ[p];
    for (std::size_t p = 0; p < 3; ++p) QV[p] = moments.QV[p];
    for (std::size_t p = 0; p < 2; ++p) VV[p] = moments.VV[p];
  }

  bool finite() const { return QQ[3].allFinite() && QV[2].allFinite() && VV[1].allFinite(); }
};

}  // namespace stiefel
