#include <array>

#include "engine/linalg/lie/so_3.h"
#include "engine/numbers/pair.h"
#include "engine/rigid_body/tangents/column_tangents.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;
using Three = std::array<Pair, 3>;
using Four = std::array<Pair, 4>;

/// Adds q∘(0, v), v a vector of R³.
[[gnu::always_inline]] inline void add_product(const Four& q, const Three& v, Four& out) {
  out[0] -= q[1] * v[0] + q[2] * v[1] + q[3] * v[2];
  out[1] += q[0] * v[0] + (q[2] * v[2] - q[3] * v[1]);
  out[2] += q[0] * v[1] + (q[3] * v[0] - q[1] * v[2]);
  out[3] += q[0] * v[2] + (q[1] * v[1] - q[2] * v[0]);
}
/// Adds q∘p.
[[gnu::always_inline]] inline void add_product(const Four& q, const Four& p, Four& out) {
  for (std::size_t i = 0; i < 4; ++i) out[i] += q[i] * p[0];
  add_product(q, Three{p[1], p[2], p[3]}, out);
}

/// Two vectors, and along them δs/s and δd of the constants s and d of the step.
struct Two {
  PairSums q, m;
  bool varies = false;
  Three by_scale = {}, by_slope = {};
};

/// Rk4 on q̇ = ½q∘(0, ω), ṁ = m × ω, that is on the quaternion of Q and M = hat(m). With a = hω/2 =
/// s·m, s = h/(2I), the stages are q∘F_i, and
///
///     a_i = s·(m + c_i g_{i−1}),   L_i = F_i∘a_i,   F_i = 1 + c_i L_{i−1},   c = 0, ½, ½, 1,
///     g = h m × ω:   g_x = d_x a_y a_z, d_x = (4/h)(λ_z − λ_y), and cyclic,
///     q′ = q + q∘P,   P = (L_1 + 2L_2 + 2L_3 + L_4)/6,   m′ = m + (g_1 + 2g_2 + 2g_3 + g_4)/6,
///
/// and the derivatives by the product rule. Values are pairs of equal numbers.
class Rk4BodyTangent3 final : public TangentMap {
 public:
  Rk4BodyTangent3(const Scene& scene, const ColumnParameters& at)
      : substeps_(scene.substeps()),
        compensated_(scene.arithmetic() == Arithmetic::compensated),
        has_frame_(scene.has_frame()),
        parameters_(at) {
    for (std::size_t k = 0; k < 3; ++k) {
      scale_[k] = at.h / (2 * sum(at.lambda, k));
      slope_[k] = 4 / at.h * difference(at.lambda, k);
    }
  }

  void start(const Dense& point, const Dense& V) override {
    set(point);
    pairs_.assign(static_cast<std::size_t>((V.cols() + 1) / 2),
                  {{has_frame_ ? 4u : 0u, compensated_}, {3, compensated_}});
    const double h = parameters_.h;
    for (Index v = 0; v < V.cols(); ++v) {
      Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      const Dense block = V.col(v).reshaped(V.rows() / 3, 3);
      const Eigen::Vector3d dm = vee(block.bottomRows(3));
      for (std::size_t k = 0; k < 3; ++k) x.m.set(k, lane, dm(static_cast<Index>(k)));
      if (has_frame_) {
        const Eigen::Vector4d q = quaternion();
        const Dense A = rotation_matrix<double>(q).transpose() * block.topRows(3);
        const Eigen::Vector3d half = vee(((A - A.transpose()) / 4).eval());
        const Eigen::Vector4d dq = So3<double, true>::quaternion_times(q, half);
        for (std::size_t i = 0; i < 4; ++i) x.q.set(i, lane, dq(static_cast<Index>(i)));
      }
      const Eigen::VectorXd by_lambda = parameters_.by_lambda.col(v);
      const double by_h = parameters_.by_h(v);
      if (by_lambda.isZero(0) && by_h == 0) continue;
      x.varies = true;
      for (std::size_t k = 0; k < 3; ++k) {
        x.by_scale[k].set(lane, by_h / h - sum(by_lambda, k) / sum(parameters_.lambda, k));
        x.by_slope[k].set(lane, 4 / h * difference(by_lambda, k) - slope_[k][0] * by_h / h);
      }
    }
  }

  RunStatus step(const Dense& point) override {
    set(point);
    for (int k = 0; k < substeps_; ++k) {
      stop_point(600 * static_cast<double>(pairs_.size() + 1));
      find_values();
      for (Two& x : pairs_)
        has_frame_ ? (x.varies ? move<true, true>(x) : move<true, false>(x))
                   : (x.varies ? move<false, true>(x) : move<false, false>(x));
      if (substeps_ > 1) advance_values();
    }
    return {};
  }

  bool direct() const override { return false; }
  RunStatus at(std::int64_t) override { return {Outcome::solver_stalled, std::nullopt}; }

  void read(const Dense& point, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v) {
      const Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      const auto of = [&](const PairSums& sums, Index i) { return sums.values()[i][lane]; };
      auto block = V.col(v).reshaped(V.rows() / 3, 3);
      block.bottomRows(3) = hat(Eigen::Vector3d(of(x.m, 0), of(x.m, 1), of(x.m, 2)));
      if (!has_frame_) continue;
      // δQ of Q v = q v q*, a form in q, is its polar form with δq.
      const Eigen::Vector4d q = point.topRows(4),
                            dq(of(x.q, 0), of(x.q, 1), of(x.q, 2), of(x.q, 3));
      block.topRows(3) = (rotation_matrix<double>(q + dq) - rotation_matrix<double>(q - dq)) / 2;
    }
  }

 private:
  struct Stage {
    Three a;
    Three first, second;  ///< the coefficients of δa_y and δa_z in δg_x, and cyclic
    Four F;
  };
  static constexpr double shares_[] = {0, 0.5, 0.5, 1};  ///< c

  /// λ_y + λ_z and λ_z − λ_y for x, and cyclic.
  static double sum(const Eigen::VectorXd& l, std::size_t k) {
    return l(static_cast<Index>((k + 1) % 3)) + l(static_cast<Index>((k + 2) % 3));
  }
  static double difference(const Eigen::VectorXd& l, std::size_t k) {
    return l(static_cast<Index>((k + 2) % 3)) - l(static_cast<Index>((k + 1) % 3));
  }

  void set(const Dense& point) {
    const double* const x = point.data();
    if (has_frame_)
      for (std::size_t i = 0; i < 4; ++i) q_[i] = x[i];
    for (std::size_t k = 0; k < 3; ++k) m_[k] = x[k + (has_frame_ ? 4 : 0)];
  }
  Eigen::Vector4d quaternion() const { return {q_[0][0], q_[1][0], q_[2][0], q_[3][0]}; }

  void find_values() {
    const Three m = m_, scale = scale_, slope = slope_;
    Three g = {}, sum_g;
    Four F = {Pair(1), 0, 0, 0}, L, sum_L;
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      Stage& at = stages_[s];
      Three a;
      for (std::size_t k = 0; k < 3; ++k)
        a[k] = scale[k] * (s == 0 ? m[k] : m[k] + Pair(shares_[s]) * g[k]);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        at.first[k] = slope[k] * a[j];
        at.second[k] = slope[k] * a[i];
        g[k] = at.first[k] * a[i];
      }
      at.a = a;
      add(s, g, sum_g);
      if (s > 0)
        for (std::size_t i = 0; i < 4; ++i) F[i] = Pair(shares_[s]) * L[i];
      if (s > 0) F[0] += Pair(1);
      at.F = F;
      L = {};
      if (s > 0)
        add_product(F, a, L);
      else
        for (std::size_t k = 0; k < 3; ++k) L[k + 1] = a[k];
      add(s, L, sum_L);
    }
    sum_g_ = sum_g;
    for (std::size_t i = 0; i < 4; ++i) P_[i] = Pair(1. / 6) * sum_L[i];
  }

  /// Sums x_1 + 2x_2 + 2x_3 + x_4.
  template <class Numbers>
  [[gnu::always_inline]] static void add(std::size_t s, const Numbers& x, Numbers& sum) {
    for (std::size_t k = 0; k < x.size(); ++k)
      sum[k] = s == 0 ? x[k] : sum[k] + (s == 3 ? x[k] : x[k] + x[k]);
  }

  template <bool frame, bool varies>
  void move(Two& x) const {
    Three dg, sum_g;
    Four dL, sum_L;
    const Pair* const m = x.m.values();
    const Three dm = {m[0], m[1], m[2]};
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      const Stage& at = stages_[s];
      const Pair share = shares_[s];
      Three da;
      for (std::size_t k = 0; k < 3; ++k) {
        da[k] = scale_[k] * (s == 0 ? dm[k] : s == 3 ? dm[k] + dg[k] : dm[k] + share * dg[k]);
        if constexpr (varies) da[k] += at.a[k] * x.by_scale[k];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        dg[k] = at.first[k] * da[i] + at.second[k] * da[j];
        if constexpr (varies) dg[k] += at.a[i] * at.a[j] * x.by_slope[k];
      }
      add(s, dg, sum_g);
      if constexpr (frame) {
        Four dF = dL;
        dL = {};
        if (s == 0) {
          for (std::size_t k = 0; k < 3; ++k) dL[k + 1] = da[k];
        } else {
          if (s < 3)
            for (Pair& number : dF) number *= share;
          add_product(dF, at.a, dL);
          add_product(at.F, da, dL);
        }
        add(s, dL, sum_L);
      }
    }
    const Pair sixth = 1. / 6;
    for (std::size_t k = 0; k < 3; ++k) x.m.add(k, sixth * sum_g[k]);
    if constexpr (frame) {
      const Pair* const q = x.q.values();
      Four change = {};
      for (Pair& number : sum_L) number *= sixth;
      add_product(Four{q[0], q[1], q[2], q[3]}, P_, change);
      add_product(q_, sum_L, change);
      for (std::size_t i = 0; i < 4; ++i) x.q.add(i, change[i]);
    }
  }

  /// The values of a further substep.
  void advance_values() {
    for (std::size_t k = 0; k < 3; ++k) m_[k] += Pair(1. / 6) * sum_g_[k];
    if (!has_frame_) return;
    Four change = {};
    add_product(q_, P_, change);
    for (std::size_t i = 0; i < 4; ++i) q_[i] += change[i];
  }

  int substeps_;
  bool compensated_, has_frame_;
  ColumnParameters parameters_;
  Three scale_, slope_;  ///< s and d
  Three m_, sum_g_ = {};
  Four q_, P_ = {};
  std::array<Stage, 4> stages_;
  std::vector<Two> pairs_;
};

}  // namespace

std::unique_ptr<TangentMap> rk4_body_tangent_3(const Scene& scene, const ColumnParameters& at) {
  return std::make_unique<Rk4BodyTangent3>(scene, at);
}

}  // namespace stiefel
