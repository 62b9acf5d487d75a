#pragma once

#include <array>

#include "engine/numbers/scalar.h"

namespace stiefel {

/// Pointers to the n × n moments of a state, stored column after column.
template <class Scalar>
struct FrameSums {
  Scalar *QQ[4], *QV[3], *VV[2];
};

/// The moments of a state on V(n, N), which determine a step: n × n sums over its N columns, with V
/// = Q̇ = SΛ⁻¹,
///
///     QQ[p] = QΛ⁻ᵖQᵀ, p = 0..3,   QV[p] = QΛ⁻ᵖVᵀ, p = 0..2,   VV[p] = VΛ⁻ᵖVᵀ, p = 0, 1.
template <class Scalar>
struct FrameMoments {
  std::array<Matrix<Scalar>, 4> QQ;
  std::array<Matrix<Scalar>, 3> QV;
  std::array<Matrix<Scalar>, 2> VV;

  explicit FrameMoments(Eigen::Index n) {
    each([n](Matrix<Scalar>& sum) { sum.setZero(n, n); });
  }

  template <class Visitor>
  void each(Visitor&& visit) {
    for (auto& sum : QQ) visit(sum);
    for (auto& sum : QV) visit(sum);
    for (auto& sum : VV) visit(sum);
  }

  FrameMoments& operator+=(const FrameMoments& other) {
    for (std::size_t p = 0; p < QQ.size(); ++p) QQ[p] += other.QQ[p];
    for (std::size_t p = 0; p < QV.size(); ++p) QV[p] += other.QV[p];
    for (std::size_t p = 0; p < VV.size(); ++p) VV[p] += other.VV[p];
    return *this;
  }

  FrameSums<Scalar> sums() {
    return {{QQ[0].data(), QQ[1].data(), QQ[2].data(), QQ[3].data()},
            {QV[0].data(), QV[1].data(), QV[2].data()},
            {VV[0].data(), VV[1].data()}};
  }

  bool finite() const { return QQ[3].allFinite() && QV[2].allFinite() && VV[1].allFinite(); }
};

}  // namespace stiefel
