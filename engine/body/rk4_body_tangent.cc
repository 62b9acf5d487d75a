#include <array>

#include "engine/body/rigid_tangents.h"
#include "engine/dense/so_3.h"
#include "engine/numbers/pair.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// Q and M as N × N matrices, column by column; M and Ω are known by all of their elements.
struct Matrices {
  using Value = double;
  static constexpr bool fixed = false;  ///< whether its matrices have a fixed size
  static constexpr double unit = 1;
  template <class T>
  using Momentum = std::vector<T>;
  template <class T>
  using Frame = std::vector<T>;

  explicit Matrices(Index n) : N(n), size(n * n) {}

  template <class T>
  Momentum<T> momentum() const {
    return std::vector<T>(static_cast<std::size_t>(size));
  }
  template <class T>
  Frame<T> frame() const {
    return momentum<T>();
  }

  template <class A, class B, class Out>
  void add_product(const std::vector<A>& of_a, const std::vector<B>& of_b,
                   std::vector<Out>& of_out) const {
    constexpr Index rows = 4;
    const A* const a = of_a.data();
    const B* b = of_b.data();
    Out* out = of_out.data();
    for (Index j = 0; j < N; ++j, b += N, out += N) {
      stop_point(static_cast<double>(size));
      Index i = 0;
      for (; i + rows <= N; i += rows) {
        Out sums[rows] = {out[i], out[i + 1], out[i + 2], out[i + 3]};
        for (Index k = 0; k < N; ++k) {
          const Out factor = b[k];
          for (Index r = 0; r < rows; ++r) sums[r] += Out(a[i + r + N * k]) * factor;
        }
        for (Index r = 0; r < rows; ++r) out[i + r] = sums[r];
      }
      for (; i < N; ++i)
        for (Index k = 0; k < N; ++k) out[i] += Out(a[i + N * k]) * Out(b[k]);
    }
  }
  /// Adds QΩ.
  void add_generated(const auto& Q, const auto& Omega, auto& out) const {
    add_product(Q, Omega, out);
  }
  void set_identity(std::vector<double>& a) const {
    std::fill(a.begin(), a.end(), 0.0);
    for (Index i = 0; i < N; ++i) a[static_cast<std::size_t>(i + N * i)] = 1;
  }
  double sum(const Eigen::VectorXd& l, Index k) const { return l(k % N) + l(k / N); }
  double difference(const Eigen::VectorXd& l, Index k) const { return l(k % N) - l(k / N); }

  /// Sets out = ΩΔ + ΔΩ: (i, j) is −Σ_k (Ω_ki Δ_kj + Δ_ki Ω_kj).
  template <class T>
  void square(const std::vector<double>& of_Omega, const std::vector<T>& of_Delta,
              std::vector<T>& of_out) const {
    const double* const Omega = of_Omega.data();
    const T* const Delta = of_Delta.data();
    T* const out = of_out.data();
    for (Index j = 0; j < N; ++j) {
      stop_point(2 * static_cast<double>(j * N));
      for (Index i = 0; i <= j; ++i) {
        T sum = 0;
        for (Index k = 0; k < N; ++k)
          sum += T(Omega[k + N * i]) * Delta[k + N * j] + Delta[k + N * i] * T(Omega[k + N * j]);
        out[i + N * j] = out[j + N * i] = -sum;
      }
    }
  }

  void set(const Dense& point, std::vector<double>& Q, std::vector<double>& M) const {
    for (Index j = 0; j < N; ++j) {
      std::copy_n(point.data() + (j + 1) * point.rows() - N, N, M.data() + N * j);
      if (point.rows() > N) std::copy_n(point.data() + j * point.rows(), N, Q.data() + N * j);
    }
  }
  /// The blocks of a vector are those of a point.
  void set_vector(const Dense&, const Dense& block, std::vector<double>& dQ,
                  std::vector<double>& dM) const {
    set(block, dQ, dM);
  }
  void read(const Dense&, const std::vector<double>& dQ, const std::vector<double>& dM,
            Dense& block) const {
    block.bottomRows(N) = Eigen::Map<const Dense>(dM.data(), N, N);
    if (block.rows() > N) block.topRows(N) = Eigen::Map<const Dense>(dQ.data(), N, N);
  }

  Index N, size;
};

/// Three dimensions: Q as a quaternion q, q̇ = q∘(0, ½ω), and M = hat(m), whose elements have the
/// order m_x, m_y, m_z. (λ_i − λ_j)(Ω²)_ij is (λ_z − λ_y)ω_yω_z, and cyclic.
struct Quaternions {
  using Value = Pair;  // two equal numbers
  static constexpr bool fixed = true;
  static constexpr double unit = 2;
  template <class T>
  using Momentum = std::array<T, 3>;
  template <class T>
  using Frame = std::array<T, 4>;

  explicit Quaternions(Index) {}

  template <class T>
  Momentum<T> momentum() const {
    return {};
  }
  template <class T>
  Frame<T> frame() const {
    return {};
  }

  /// Adds q∘p.
  void add_product(const Frame<Pair>& q, const Frame<Pair>& p, Frame<Pair>& out) const {
    for (std::size_t i = 0; i < 4; ++i) out[i] += q[i] * p[0];
    add_imaginary(q, {p[1], p[2], p[3]}, out);
  }
  void add_generated(const Frame<Pair>& q, const Momentum<Pair>& a, Frame<Pair>& out) const {
    add_imaginary(q, a, out);
  }
  void set_identity(Frame<Pair>& q) const { q = {Pair(1), Pair(0), Pair(0), Pair(0)}; }
  double sum(const Eigen::VectorXd& l, Index k) const { return l((k + 1) % 3) + l((k + 2) % 3); }
  double difference(const Eigen::VectorXd& l, Index k) const {
    return l((k + 2) % 3) - l((k + 1) % 3);
  }
  void square(const Momentum<Pair>& omega, const Momentum<Pair>& delta, Momentum<Pair>& out) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      out[k] = omega[i] * delta[j] + delta[i] * omega[j];
    }
  }

  void set(const Dense& point, Frame<Pair>& q, Momentum<Pair>& m) const {
    std::copy_n(point.data() + point.size() - 3, 3, m.begin());
    if (point.size() > 3) std::copy_n(point.data(), 4, q.begin());
  }
  /// δq = ½q∘(0, η), η the skew part of QᵀδQ.
  void set_vector(const Dense& point, const Dense& block, Frame<double>& dq,
                  Momentum<double>& dm) const {
    Eigen::Map<Eigen::Vector3d>(dm.data()) = vee(block.bottomRows(3));
    if (block.rows() == 3) return;
    const Eigen::Vector4d at = point.topRows(4);
    const Dense A = rotation_matrix<double>(at).transpose() * block.topRows(3);
    Eigen::Map<Eigen::Vector4d>(dq.data()) =
        So3<double, true>::quaternion_times(at, vee(((A - A.transpose()) / 4).eval()));
  }
  /// Q is a form in q, so that δQ is its polar form with δq.
  void read(const Dense& point, const Frame<double>& of_dq, const Momentum<double>& dm,
            Dense& block) const {
    block.bottomRows(3) = hat(Eigen::Vector3d(dm.data()));
    if (block.rows() == 3) return;
    const Eigen::Vector4d q = point.topRows(4), dq(of_dq.data());
    block.topRows(3) = (rotation_matrix<double>(q + dq) - rotation_matrix<double>(q - dq)) / 2;
  }

 private:
  /// Adds q∘(0, v).
  [[gnu::always_inline]] static void add_imaginary(const Frame<Pair>& q, const Momentum<Pair>& v,
                                                   Frame<Pair>& out) {
    out[0] -= q[1] * v[0] + q[2] * v[1] + q[3] * v[2];
    out[1] += q[0] * v[0] + (q[2] * v[2] - q[3] * v[1]);
    out[2] += q[0] * v[1] + (q[3] * v[0] - q[1] * v[2]);
    out[3] += q[0] * v[2] + (q[1] * v[1] - q[2] * v[0]);
  }
};

/// Rk4 on Q̇ = QΩ, Ṁ = [M, Ω]. With A = hΩ = s∘M, s_ij = h/(λ_i + λ_j), the stages of Q are QF_i,
/// and
///
///     A_i = s∘(M + c_i g_{i−1}),   K_i = F_iA_i,   F_i = I + c_i K_{i−1},   c = 0, ½, ½, 1,
///     g = h[M, Ω] = d∘A²,   d_ij = (λ_i − λ_j)/h,
///     Q′ = Q + QP,   P = (K_1 + 2K_2 + 2K_3 + K_4)/6,   M′ = M + (g_1 + 2g_2 + 2g_3 + g_4)/6,
///
/// and the derivatives by the product rule. A Space has the elements of M and A, which is hΩ/unit,
/// the λ_i + λ_j and λ_i − λ_j that belong to them, and the products of frames.
template <class Space>
class Rk4BodyTangent final : public TangentMap {
 public:
  Rk4BodyTangent(const Scene& scene, const TangentParameters& at)
      : substeps_(scene.substeps()),
        compensated_(scene.arithmetic() == Arithmetic::compensated),
        has_frame_(scene.has_frame()),
        space_(scene.dimension()),
        parameters_(at) {
    scale_ = slope_ = M_ = sum_g_ = space_.template momentum<Value>();
    Q_ = P_ = space_.template frame<Value>();
    for (std::size_t k = 0; k < M_.size(); ++k) {
      const double sum = space_.sum(at.lambda, index(k));  // 0 at most for i = j
      scale_[k] = sum == 0 ? 0 : at.h / (Space::unit * sum);
      slope_[k] = slope(at.lambda, k);
    }
    for (Stage& s : stages_) s = {M_, M_, M_, Q_, Q_};
    work_.dA = work_.dg = work_.sum_dg = space_.template momentum<Pair>();
    work_.dK = work_.dF = work_.sum_dK = space_.template frame<Pair>();
  }

  void start(const Dense& point, const Dense& V) override {
    pairs_.assign(static_cast<std::size_t>((V.cols() + 1) / 2),
                  {{has_frame_ ? Q_.size() : 0, compensated_}, {M_.size(), compensated_}});
    auto dQ = space_.template frame<double>();
    auto dM = space_.template momentum<double>();
    const Index N = parameters_.lambda.size();
    const double h = parameters_.h;
    for (Index v = 0; v < V.cols(); ++v) {
      auto& x = pairs_[static_cast<std::size_t>(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      space_.set_vector(point, V.col(v).reshaped(V.rows() / N, N), dQ, dM);
      for (std::size_t i = 0; i < dM.size(); ++i) x.M.set(i, lane, dM[i]);
      for (std::size_t i = 0; has_frame_ && i < dQ.size(); ++i) x.Q.set(i, lane, dQ[i]);
      if (parameters_.constant(v)) continue;
      if (!x.varies) x.by_scale = x.by_slope = space_.template momentum<Pair>();
      x.varies = true;
      const Eigen::VectorXd by_lambda = parameters_.by_lambda.col(v);
      const double by_h = parameters_.by_h(v);
      for (std::size_t k = 0; k < M_.size(); ++k) {
        const double sum = space_.sum(parameters_.lambda, index(k));
        if (sum != 0) x.by_scale[k].set(lane, by_h / h - space_.sum(by_lambda, index(k)) / sum);
        x.by_slope[k].set(lane, slope(by_lambda, k) - slope(parameters_.lambda, k) * by_h / h);
      }
    }
  }

  RunStatus step(const Dense& point) override {
    space_.set(point, Q_, M_);
    for (int k = 0; k < substeps_; ++k) {
      stop_point(600 * static_cast<double>(pairs_.size() + 1));
      find_values();
      for (auto& x : pairs_) has_frame_ ? move<true>(x) : move<false>(x);
      if (substeps_ > 1) advance_values();
    }
    return {};
  }

  void read(const Dense& point, Dense& V) const override {
    auto dQ = space_.template frame<double>();
    auto dM = space_.template momentum<double>();
    const Index N = parameters_.lambda.size();
    Dense block(V.rows() / N, N);
    for (Index v = 0; v < V.cols(); ++v) {
      const auto& x = pairs_[static_cast<std::size_t>(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      for (std::size_t i = 0; i < dM.size(); ++i) dM[i] = x.M.values()[i][lane];
      for (std::size_t i = 0; has_frame_ && i < dQ.size(); ++i) dQ[i] = x.Q.values()[i][lane];
      space_.read(point, dQ, dM, block);
      V.col(v) = block.reshaped();
    }
  }

 private:
  template <class T>
  using Momentum = typename Space::template Momentum<T>;
  template <class T>
  using Frame = typename Space::template Frame<T>;
  using Value = typename Space::Value;

  struct Stage {
    Momentum<Value> A, square, g;  ///< A_i, A_i², g_i
    Frame<Value> F, K;
  };
  /// Two vectors, and along them δs/s and δd.
  struct Two {
    PairSums Q, M;
    bool varies = false;  ///< whether these are not zero
    Momentum<Pair> by_scale = {}, by_slope = {};
  };
  struct Work {
    Momentum<Pair> dA, dg, sum_dg;
    Frame<Pair> dK, dF, sum_dK;
  };
  static constexpr double nodes_[] = {0, 0.5, 0.5, 1};

  static Index index(std::size_t k) { return static_cast<Index>(k); }
  double slope(const Eigen::VectorXd& lambda, std::size_t k) const {
    return Space::unit * Space::unit * space_.difference(lambda, index(k)) / parameters_.h;
  }

  /// Sums x_1 + 2x_2 + 2x_3 + x_4.
  [[gnu::always_inline]] static void add(std::size_t s, const auto& x, auto& sum) {
    for (std::size_t k = 0; k < x.size(); ++k)
      sum[k] = s == 0 ? x[k] : sum[k] + (s == 3 ? x[k] : x[k] + x[k]);
  }

  void find_values() {
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      auto& [A, square, g, F, K] = stages_[s];
      const Value share = nodes_[s], half = 0.5;
      for (std::size_t k = 0; k < M_.size(); ++k)
        A[k] = scale_[k] * (s == 0 ? M_[k] : M_[k] + share * stages_[s - 1].g[k]);
      space_.square(A, A, square);
      for (std::size_t k = 0; k < M_.size(); ++k) {
        square[k] *= half;
        g[k] = slope_[k] * square[k];
      }
      add(s, g, sum_g_);
      if (!has_frame_) continue;
      space_.set_identity(F);
      if (s > 0)
        for (std::size_t i = 0; i < F.size(); ++i) F[i] += share * stages_[s - 1].K[i];
      std::fill(K.begin(), K.end(), Value(0));
      space_.add_generated(F, A, K);
      add(s, K, P_);
    }
    for (Value& number : P_) number *= Value(1. / 6);
  }

  template <bool frame>
  void move(Two& x) {
    // Registers hold what has a fixed size.
    std::conditional_t<Space::fixed, Work, Work&> work = work_;
    auto& [dA, dg, sum_dg, dK, dF, sum_dK] = work;
    const Pair* const dM = x.M.values();
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      const Stage& at = stages_[s];
      const Pair share = nodes_[s];
      for (std::size_t k = 0; k < dA.size(); ++k)
        dA[k] = Pair(scale_[k]) * (s == 0 ? dM[k] : dM[k] + share * dg[k]);
      if (x.varies)
        for (std::size_t k = 0; k < dA.size(); ++k) dA[k] += Pair(at.A[k]) * x.by_scale[k];
      space_.square(at.A, dA, dg);
      for (std::size_t k = 0; k < dg.size(); ++k) dg[k] *= Pair(slope_[k]);
      if (x.varies)
        for (std::size_t k = 0; k < dg.size(); ++k) dg[k] += Pair(at.square[k]) * x.by_slope[k];
      add(s, dg, sum_dg);
      if constexpr (frame) {
        if (s > 0)
          for (std::size_t i = 0; i < dF.size(); ++i) dF[i] = share * dK[i];
        std::fill(dK.begin(), dK.end(), Pair(0));
        if (s > 0) space_.add_generated(dF, at.A, dK);
        space_.add_generated(at.F, dA, dK);
        add(s, dK, sum_dK);
      }
    }
    const Pair sixth = 1. / 6;
    for (std::size_t k = 0; k < sum_dg.size(); ++k) x.M.add(k, sixth * sum_dg[k]);
    if constexpr (frame) {
      for (Pair& number : sum_dK) number *= sixth;
      std::copy_n(x.Q.values(), dK.size(), dK.begin());
      std::fill(dF.begin(), dF.end(), Pair(0));
      space_.add_product(dK, P_, dF);
      space_.add_product(Q_, sum_dK, dF);
      for (std::size_t i = 0; i < dF.size(); ++i) x.Q.add(i, dF[i]);
    }
  }

  /// The values of a further substep.
  void advance_values() {
    for (std::size_t k = 0; k < M_.size(); ++k) M_[k] += Value(1. / 6) * sum_g_[k];
    if (!has_frame_) return;
    auto change = space_.template frame<Value>();
    space_.add_product(Q_, P_, change);
    for (std::size_t i = 0; i < Q_.size(); ++i) Q_[i] += change[i];
  }

  int substeps_;
  bool compensated_, has_frame_;
  Space space_;
  TangentParameters parameters_;
  Momentum<Value> scale_, slope_;  ///< s and d
  Momentum<Value> M_, sum_g_;
  Frame<Value> Q_, P_;
  std::array<Stage, 4> stages_;
  std::vector<Two> pairs_;
  Work work_;
};

}  // namespace

std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const TangentParameters& at) {
  if (scene.dimension() == 3) return std::make_unique<Rk4BodyTangent<Quaternions>>(scene, at);
  return std::make_unique<Rk4BodyTangent<Matrices>>(scene, at);
}

}  // namespace stiefel
