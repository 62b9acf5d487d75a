#include <array>

#include "engine/body/rigid_tangents.h"
#include "engine/dense/so_3.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/pair.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// States as matrices, Q over M or M alone.
struct Matrices {
  static constexpr bool fixed = false;  ///< whether states have a fixed size
  using State = Matrix<Pair>;
  using Algebra = Matrix<Pair>;
  using Lambda = Vector<Pair>;

  static auto momentum(auto& x) { return x.bottomRows(x.cols()); }
  /// Returns 1/(λ_i + λ_j), 0 for i = j: Ω_ij = M_ij/(λ_i + λ_j).
  static Algebra inverse_inertia(const Lambda& lambda) {
    Algebra out = J(lambda, Algebra::Ones(lambda.size(), lambda.size())).cwiseInverse();
    out.diagonal().setZero();
    return out;
  }
  /// Returns δΛΩ + ΩδΛ.
  static Algebra J(const Lambda& dlambda, const Algebra& Omega) {
    return dlambda.asDiagonal() * Omega + Omega * dlambda.asDiagonal();
  }

  /// Computes (QΩ, [Λ, Ω²]).
  static void velocity(const Lambda& lambda, const State& x, const Algebra& Omega, State& out) {
    const Index N = x.cols();
    out.resize(x.rows(), N);
    if (x.rows() > N) product<false>(x.topRows(N), Omega, out.topRows(N));
    auto square = out.bottomRows(N);
    product<false>(Omega, Omega, square);
    for (Index j = 0; j < N; ++j)
      for (Index i = 0; i < N; ++i) square(i, j) *= lambda(i) - lambda(j);
  }
  /// Computes the derivative of `velocity` along (dx, δΩ): (δQΩ + QδΩ, [Λ, ΩδΩ + δΩΩ]), where δΩΩ =
  /// (ΩδΩ)ᵀ.
  static void variation(const Lambda& lambda, const State& x, const Algebra& Omega, const State& dx,
                        const Algebra& dOmega, State& out) {
    const Index N = x.cols();
    out.resize(x.rows(), N);
    if (x.rows() > N) {
      product<false>(dx.topRows(N), Omega, out.topRows(N));
      product<true>(x.topRows(N), dOmega, out.topRows(N));
    }
    auto Y = out.bottomRows(N);
    product<false>(Omega, dOmega, Y);
    for (Index j = 0; j < N; ++j) {
      Y(j, j) = 0;
      for (Index i = 0; i < j; ++i) {
        Y(i, j) = (lambda(i) - lambda(j)) * (Y(i, j) + Y(j, i));
        Y(j, i) = -Y(i, j);
      }
    }
  }

  /// Points and vectors are blocks already.
  static State of_point(const Dense& point) { return point.cast<Pair>(); }
  static Dense of_block(const Dense&, const Dense& block) { return block; }
  static Dense block(const Dense&, const Dense& dx) { return dx; }

 private:
  /// Sets out to ab, or adds ab, four rows at a time.
  template <bool adds, class A, class B, class Out>
  static void product(const A& a, const B& b, Out&& out) {
    const Index N = b.cols();
    for (Index j = 0; j < N; ++j) {
      stop_point(static_cast<double>(N * N));
      const auto rows = [&]<int count>(std::integral_constant<int, count>, Index i) {
        Pair sums[count];
        for (int r = 0; r < count; ++r) sums[r] = adds ? out(i + r, j) : Pair(0);
        for (Index k = 0; k < N; ++k)
          for (int r = 0; r < count; ++r) sums[r] += a(i + r, k) * b(k, j);
        for (int r = 0; r < count; ++r) out(i + r, j) = sums[r];
      };
      Index i = 0;
      for (; i + 4 <= N; i += 4) rows(std::integral_constant<int, 4>(), i);
      for (; i < N; ++i) rows(std::integral_constant<int, 1>(), i);
    }
  }
};

/// Three dimensions: (q; m), or m alone.
template <bool frame>
struct Quaternions : So3<Pair, frame> {
  using Space = So3<Pair, frame>;
  using Space::quaternion_times;
  using typename Space::State, typename Space::Algebra, typename Space::Lambda;
  static constexpr bool fixed = true;

  static auto momentum(auto& x) { return x.template tail<3>(); }
  static Algebra inverse_inertia(const Lambda& lambda) {
    return J(lambda, Algebra::Ones()).cwiseInverse();
  }
  static Algebra J(const Lambda& dlambda, const Algebra& omega) {
    return {(dlambda(1) + dlambda(2)) * omega(0), (dlambda(2) + dlambda(0)) * omega(1),
            (dlambda(0) + dlambda(1)) * omega(2)};
  }
  static void variation(const Lambda& lambda, const State& x, const Algebra& omega, const State& dx,
                        const Algebra& domega, State& out) {
    if constexpr (frame)
      out.template head<4>() =
          Pair(0.5) * (quaternion_times(dx, omega) + quaternion_times(x, domega));
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      momentum(out)(k) = (lambda(j) - lambda(i)) * (omega(i) * domega(j) + domega(i) * omega(j));
    }
  }

  static State of_point(const Dense& point) { return point.cast<Pair>(); }
  /// δq = ½q∘(0, η), η the skew part of QᵀδQ.
  static Dense of_block(const Dense& point, const Dense& block) {
    Dense dx(frame ? 7 : 3, 1);
    dx.bottomRows(3) = vee(block.bottomRows(3));
    if constexpr (frame) {
      const Eigen::Vector4d q = point.topRows(4);
      const Dense A = rotation_matrix<double>(q).transpose() * block.topRows(3);
      dx.topRows(4) = So3<double, true>::quaternion_times(q, vee(((A - A.transpose()) / 4).eval()));
    }
    return dx;
  }
  /// Q is a form in q, so that δQ is its polar form with δq.
  static Dense block(const Dense& point, const Dense& dx) {
    Dense out(frame ? 6 : 3, 3);
    out.bottomRows(3) = hat(Eigen::Vector3d(dx.bottomRows(3)));
    if constexpr (frame) {
      const Eigen::Vector4d q = point.topRows(4), dq = dx.topRows(4);
      out.topRows(3) = (rotation_matrix<double>(q + dq) - rotation_matrix<double>(q - dq)) / 2;
    }
    return out;
  }
};

/// Rk4 on x = (Q, M), Ω = J⁻¹(M), ẋ = (QΩ, [Λ, Ω²]), and its derivative stage by stage by the chain
/// rule.
template <class Space>
class Rk4BodyTangent final : public TangentMap {
 public:
  Rk4BodyTangent(const Scene& scene, const TangentParameters& at)
      : substeps_(scene.substeps()),
        arithmetic_(scene.arithmetic()),
        parameters_(at),
        lambda_(at.lambda.cast<Pair>()),
        inverse_inertia_(Space::inverse_inertia(lambda_)) {}

  void start(const Dense& point, const Dense& V) override {
    const Index N = parameters_.lambda.size(), rows = V.rows() / N;
    vectors_.clear();
    for (Index first = 0; first < V.cols(); first += 2) {
      // Returns the numbers of two vectors, of which the second may be missing.
      const auto both = [&](auto&& of) {
        const Dense a = of(first), b = first + 1 < V.cols() ? of(first + 1) : Dense(0 * a);
        return Matrix<Pair>(Matrix<Pair>::NullaryExpr(a.rows(), a.cols(), [&](Index i, Index j) {
          return Pair::of_lanes([&](int k) { return (k == 0 ? a : b)(i, j); });
        }));
      };
      Vectors& x = vectors_.emplace_back();
      x.sum = Sum(both([&](Index v) { return Space::of_block(point, V.col(v).reshaped(rows, N)); }),
                  arithmetic_);
      x.by_lambda = both([&](Index v) -> Dense { return parameters_.by_lambda.col(v); });
      x.by_h = both([&](Index v) -> Dense { return parameters_.by_h.segment(v, 1); })(0, 0);
      for (Index v = first; v < std::min(first + 2, V.cols()); ++v)
        x.varies = x.varies || !parameters_.constant(v);
    }
  }

  RunStatus step(const Dense& point) override {
    State x = Space::of_point(point);
    for (int k = 0; k < substeps_; ++k) {
      stop_point(600 * static_cast<double>(vectors_.size() + 1));
      find_values(x);
      for (Vectors& v : vectors_) move(v);
      x += Pair(parameters_.h / 6) * sum_k_;
    }
    return {};
  }

  void read(const Dense& point, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v) {
      const State& x = vectors_[static_cast<std::size_t>(v / 2)].sum.value;
      const Dense dx = Dense::NullaryExpr(x.rows(), x.cols(), [&](Index i, Index j) {
        double each[2];
        x(i, j).store(each);
        return each[v % 2];
      });
      V.col(v) = Space::block(point, dx).reshaped();
    }
  }

 private:
  using State = typename Space::State;
  using Algebra = typename Space::Algebra;
  using Lambda = typename Space::Lambda;
  using Sum = Accumulator<State>;
  static constexpr double nodes_[] = {0, 0.5, 0.5, 1};

  struct Stage {
    State x, k;
    Algebra Omega;
  };
  struct Vectors {
    Sum sum;
    Lambda by_lambda;
    Pair by_h;
    bool varies = false;  ///< whether these are not zero
  };
  struct Work {
    State dx, dk, sum;
    Algebra dOmega;
  };

  /// Adds stage s of four to a sum x_1 + 2x_2 + 2x_3 + x_4.
  [[gnu::always_inline]] static void add(std::size_t s, const State& x, State& sum) {
    if (s == 0)
      sum = x;
    else if (s == 3)
      sum += x;
    else
      sum += x + x;
  }

  void find_values(const State& x) {
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      Stage& at = stages_[s];
      if (s == 0)
        at.x = x;
      else
        at.x = x + Pair(nodes_[s] * parameters_.h) * stages_[s - 1].k;
      at.Omega = inverse_inertia_.cwiseProduct(Space::momentum(at.x));
      Space::velocity(lambda_, at.x, at.Omega, at.k);
      add(s, at.k, sum_k_);
    }
  }

  void move(Vectors& v) {
    // Registers hold what has a fixed size.
    std::conditional_t<Space::fixed, Work, Work&> work = work_;
    auto& [dx, dk, sum, dOmega] = work;
#pragma GCC unroll 4
    for (std::size_t s = 0; s < 4; ++s) {
      const Stage& at = stages_[s];
      if (s == 0)
        dx = v.sum.value;
      else
        dx = v.sum.value + Pair(nodes_[s] * parameters_.h) * dk;
      if (v.varies) {
        if (s > 0) dx += (Pair(nodes_[s]) * v.by_h) * stages_[s - 1].k;
        Space::momentum(dx) -= Space::J(v.by_lambda, at.Omega);
      }
      dOmega = inverse_inertia_.cwiseProduct(Space::momentum(dx));
      Space::variation(lambda_, at.x, at.Omega, dx, dOmega, dk);
      if (v.varies) {
        Space::velocity(v.by_lambda, at.x, at.Omega, dx);
        Space::momentum(dk) += Space::momentum(dx);
      }
      add(s, dk, sum);
    }
    sum *= Pair(parameters_.h / 6);
    if (v.varies) sum += (v.by_h * Pair(1. / 6)) * sum_k_;
    v.sum.add(sum);
  }

  int substeps_;
  Arithmetic arithmetic_;
  TangentParameters parameters_;
  Lambda lambda_;
  Algebra inverse_inertia_;
  std::array<Stage, 4> stages_;
  State sum_k_;
  std::vector<Vectors> vectors_;
  Work work_;
};

}  // namespace

std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const TangentParameters& at) {
  if (scene.dimension() != 3) return std::make_unique<Rk4BodyTangent<Matrices>>(scene, at);
  if (scene.has_frame()) return std::make_unique<Rk4BodyTangent<Quaternions<true>>>(scene, at);
  return std::make_unique<Rk4BodyTangent<Quaternions<false>>>(scene, at);
}

}  // namespace stiefel
