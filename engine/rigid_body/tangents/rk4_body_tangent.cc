#include "engine/rigid_body/tangents/column_tangents.h"

#include <array>

#include "engine/numbers/pair.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// Q and M as N × N matrices, column by column; M is known by all of its elements.
struct Matrices {
  explicit Matrices(Index n) : N(n), size(n * n) {}

  template <class T>
  std::vector<T> zero() const {
    return std::vector<T>(static_cast<std::size_t>(size));
  }

  template <class A, class B, class Out>
  void add_product(const A* a, const B* b, Out* out) const {
    constexpr Index rows = 4;
    for (Index j = 0; j < N; ++j, b += N, out += N) {
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
  void set_identity(double* a) const {
    std::fill_n(a, N * N, 0.0);
    for (Index i = 0; i < N; ++i) a[i + N * i] = 1;
  }
  template <class Lambda>
  auto sum(const Lambda& l, Index k) const {
    return l(k % N) + l(k / N);
  }
  template <class Lambda>
  auto difference(const Lambda& l, Index k) const {
    return l(k % N) - l(k / N);
  }

  /// Sets out = ΩΔ + ΔΩ: (i, j) is −Σ_k (Ω_ki Δ_kj + Δ_ki Ω_kj).
  template <class T>
  void square(const double* Omega, const T* Delta, T* out) const {
    for (Index j = 0; j < N; ++j)
      for (Index i = 0; i <= j; ++i) {
        T sum = 0;
        for (Index k = 0; k < N; ++k)
          sum += T(Omega[k + N * i]) * Delta[k + N * j] + Delta[k + N * i] * T(Omega[k + N * j]);
        out[i + N * j] = out[j + N * i] = -sum;
      }
  }

  void set(const Dense& point, double* Q, double* M) const {
    const bool has_frame = point.rows() > N;
    for (Index j = 0; j < N; ++j) {
      std::copy_n(point.data() + (j + 1) * point.rows() - N, N, M + N * j);
      if (has_frame) std::copy_n(point.data() + j * point.rows(), N, Q + N * j);
    }
  }
  void read(const double* dQ, const double* dM, Dense& block) const {
    for (Index j = 0; j < N; ++j)
      for (Index i = 0; i < N; ++i) {
        block(block.rows() - N + i, j) = dM[i + N * j];
        if (block.rows() > N) block(i, j) = dQ[i + N * j];
      }
  }

  Index N, size;
};

/// Rk4 on Q̇ = QΩ, Ṁ = [M, Ω]. The stages of Q are QF_i, so that
///
///     M_i = M + c_i h f_{i−1},   K_i = F_iΩ_i,   F_i = I + c_i h K_{i−1},   c = 0, ½, ½, 1,
///     Q′ = Q + QP,   P = (h/6)(K_1 + 2K_2 + 2K_3 + K_4),   M′ = M + (h/6)(f_1 + 2f_2 + 2f_3 +
///     f_4),
///
/// and the derivatives by the product rule. f_ij = (λ_i − λ_j)(Ω²)_ij.
class Rk4BodyTangent final : public TangentMap {
 public:
  Rk4BodyTangent(const Scene& scene, const ColumnParameters& at)
      : substeps_(scene.substeps()),
        compensated_(scene.arithmetic() == Arithmetic::compensated),
        has_frame_(scene.has_frame()),
        space_(scene.dimension()),
        parameters_(at) {
    inverse_ = difference_ = M_ = Q_ = P_ = space_.zero<double>();
    for (Index k = 0; k < space_.size; ++k) {
      const double sum = space_.sum(at.lambda, k);  // 0 at most for i = j
      inverse_[count(k)] = sum == 0 ? 0 : 1 / sum;
      difference_[count(k)] = space_.difference(at.lambda, k);
    }
    for (Stage& s : stages_) s = {M_, M_, M_, Q_, Q_};
    dOmega_ = df_ = sum_f_ = dK_ = dF_ = sum_K_ = space_.zero<Pair>();
  }

  void start(const Dense& point, const Dense& V) override {
    space_.set(point, Q_.data(), M_.data());
    pairs_.assign(
        count((V.cols() + 1) / 2),
        {{has_frame_ ? Q_.size() : 0, compensated_}, {M_.size(), compensated_}, 0, {}, {}});
    auto dQ = Q_, dM = M_;
    const Index N = parameters_.lambda.size();
    for (Index v = 0; v < V.cols(); ++v) {
      auto& x = pairs_[count(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      space_.set(V.col(v).reshaped(V.rows() / N, N), dQ.data(), dM.data());
      for (std::size_t i = 0; i < dM.size(); ++i) x.M.set(i, lane, dM[i]);
      for (std::size_t i = 0; has_frame_ && i < dQ.size(); ++i) x.Q.set(i, lane, dQ[i]);
      const Eigen::VectorXd by_lambda = parameters_.by_lambda.col(v);
      if (by_lambda.isZero(0) && parameters_.by_h(v) == 0) continue;
      x.by_h.set(lane, parameters_.by_h(v));
      x.by_sum.resize(M_.size(), 0.0);
      x.by_difference.resize(M_.size(), 0.0);
      for (Index k = 0; k < space_.size; ++k) {
        x.by_sum[count(k)].set(lane, space_.sum(by_lambda, k));
        x.by_difference[count(k)].set(lane, space_.difference(by_lambda, k));
      }
    }
  }

  RunStatus step(const Dense& point) override {
    space_.set(point, Q_.data(), M_.data());
    for (int k = 0; k < substeps_; ++k) {
      find_values();
      for (auto& x : pairs_) move(x);
      advance_values();
    }
    return {};
  }

  bool direct() const override { return false; }
  RunStatus at(std::int64_t) override { return {Outcome::solver_stalled, std::nullopt}; }

  void read(const Dense&, Dense& V) const override {
    auto dQ = Q_, dM = M_;
    const Index N = parameters_.lambda.size();
    Dense block(V.rows() / N, N);
    for (Index v = 0; v < V.cols(); ++v) {
      const auto& x = pairs_[count(v / 2)];
      const auto lane = static_cast<int>(v % 2);
      for (std::size_t i = 0; i < dM.size(); ++i) dM[i] = x.M.values()[i][lane];
      for (std::size_t i = 0; has_frame_ && i < dQ.size(); ++i) dQ[i] = x.Q.values()[i][lane];
      space_.read(dQ.data(), dM.data(), block);
      V.col(v) = block.reshaped();
    }
  }

 private:
  struct Stage {
    std::vector<double> Omega, square, f;  ///< Ω_i, 2Ω_i², f_i
    std::vector<double> F, K;
  };
  /// Two vectors, and the derivatives of h, λ_i + λ_j and λ_i − λ_j along them.
  struct Two {
    PairSums Q, M;
    Pair by_h = 0;
    std::vector<Pair> by_sum, by_difference;  ///< empty where the parameters are constant
  };
  static constexpr double nodes_[] = {0, 0.5, 0.5, 1}, weights_[] = {1, 2, 2, 1};

  static std::size_t count(Index n) { return static_cast<std::size_t>(n); }

  void find_values() {
    std::fill(P_.begin(), P_.end(), 0.0);
    const double h = parameters_.h;
    for (std::size_t s = 0; s < 4; ++s) {
      auto& [Omega, square, f, F, K] = stages_[s];
      const double shift = nodes_[s] * h;
      for (std::size_t k = 0; k < M_.size(); ++k)
        Omega[k] = inverse_[k] * (s == 0 ? M_[k] : M_[k] + shift * stages_[s - 1].f[k]);
      space_.square(Omega.data(), Omega.data(), square.data());
      for (std::size_t k = 0; k < M_.size(); ++k) f[k] = difference_[k] * square[k] / 2;
      if (!has_frame_) continue;
      space_.set_identity(F.data());
      if (s > 0)
        for (std::size_t i = 0; i < F.size(); ++i) F[i] += shift * stages_[s - 1].K[i];
      std::fill(K.begin(), K.end(), 0.0);
      space_.add_product(F.data(), Omega.data(), K.data());
      for (std::size_t i = 0; i < K.size(); ++i) P_[i] += weights_[s] / 6 * h * K[i];
    }
  }

  void move(Two& x) {
    stop_point(26 * static_cast<double>(space_.size * parameters_.lambda.size()));
    const bool varies = !x.by_sum.empty();
    std::fill(sum_f_.begin(), sum_f_.end(), Pair(0));
    std::fill(sum_K_.begin(), sum_K_.end(), Pair(0));
    for (std::size_t s = 0; s < 4; ++s) {
      move_momentum(x, s);
      if (varies) add_parameters(x, s);
      for (std::size_t k = 0; k < df_.size(); ++k) sum_f_[k] += Pair(weights_[s]) * df_[k];
      if (has_frame_) move_frame(x, s);
    }
    const Pair sixth = parameters_.h / 6;
    for (std::size_t k = 0; k < sum_f_.size(); ++k) x.M.add(k, sixth * sum_f_[k]);
    if (!has_frame_) return;
    for (Pair& sum : sum_K_) sum *= sixth;
    std::fill(dF_.begin(), dF_.end(), Pair(0));
    space_.add_product(x.Q.values(), P_.data(), dF_.data());
    space_.add_product(Q_.data(), sum_K_.data(), dF_.data());
    for (std::size_t i = 0; i < dF_.size(); ++i) x.Q.add(i, dF_[i]);
  }

  void move_momentum(const Two& x, std::size_t s) {
    const Pair shift = nodes_[s] * parameters_.h;
    const Pair* const dM = x.M.values();
    for (std::size_t k = 0; k < dOmega_.size(); ++k)
      dOmega_[k] = Pair(inverse_[k]) * (s == 0 ? dM[k] : dM[k] + shift * df_[k]);
    if (!x.by_sum.empty())
      for (std::size_t k = 0; k < dOmega_.size(); ++k) {
        const double earlier = s == 0 ? 0 : nodes_[s] * stages_[s - 1].f[k];
        dOmega_[k] +=
            Pair(inverse_[k]) * (x.by_h * Pair(earlier) - Pair(stages_[s].Omega[k]) * x.by_sum[k]);
      }
    space_.square(stages_[s].Omega.data(), dOmega_.data(), df_.data());
    for (std::size_t k = 0; k < df_.size(); ++k) df_[k] *= Pair(difference_[k]);
  }

  void add_parameters(const Two& x, std::size_t s) {
    const Pair part = x.by_h * Pair(weights_[s] / parameters_.h);
    for (std::size_t k = 0; k < df_.size(); ++k) {
      df_[k] += x.by_difference[k] * Pair(stages_[s].square[k] / 2);
      sum_f_[k] += part * Pair(stages_[s].f[k]);
    }
    if (!has_frame_) return;
    for (std::size_t i = 0; i < sum_K_.size(); ++i) sum_K_[i] += part * Pair(stages_[s].K[i]);
  }

  void move_frame(const Two& x, std::size_t s) {
    const Stage& at = stages_[s];
    if (s > 0) {
      const Pair shift = nodes_[s] * parameters_.h;
      for (std::size_t i = 0; i < dF_.size(); ++i) dF_[i] = shift * dK_[i];
      if (!x.by_sum.empty())
        for (std::size_t i = 0; i < dF_.size(); ++i)
          dF_[i] += x.by_h * Pair(nodes_[s] * stages_[s - 1].K[i]);
    }
    std::fill(dK_.begin(), dK_.end(), Pair(0));
    if (s > 0) space_.add_product(dF_.data(), at.Omega.data(), dK_.data());
    space_.add_product(at.F.data(), dOmega_.data(), dK_.data());
    for (std::size_t i = 0; i < dK_.size(); ++i) sum_K_[i] += Pair(weights_[s]) * dK_[i];
  }

  /// The values of a further substep.
  void advance_values() {
    if (substeps_ == 1) return;
    for (std::size_t s = 0; s < 4; ++s)
      for (std::size_t k = 0; k < M_.size(); ++k)
        M_[k] += weights_[s] / 6 * parameters_.h * stages_[s].f[k];
    if (!has_frame_) return;
    auto Q = space_.zero<Pair>();
    std::copy(Q_.begin(), Q_.end(), Q.begin());
    std::fill(dF_.begin(), dF_.end(), Pair(0));
    space_.add_product(Q.data(), P_.data(), dF_.data());
    for (std::size_t i = 0; i < Q_.size(); ++i) Q_[i] += dF_[i][0];
  }

  int substeps_;
  bool compensated_, has_frame_;
  Matrices space_;
  ColumnParameters parameters_;
  std::vector<double> inverse_, difference_;  ///< 1/(λ_i + λ_j) and λ_i − λ_j
  std::vector<double> M_, Q_, P_;
  std::array<Stage, 4> stages_;
  std::vector<Two> pairs_;
  std::vector<Pair> dOmega_, df_, sum_f_, dK_, dF_, sum_K_;
};

}  // namespace

std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const ColumnParameters& at) {
  return std::make_unique<Rk4BodyTangent>(scene, at);
}

}  // namespace stiefel
