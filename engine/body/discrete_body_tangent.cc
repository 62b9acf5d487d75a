#include <cmath>
#include <optional>

#include "engine/body/j_d/rotation_n.h"
#include "engine/body/moser_veselov.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/body/rigid_tangents.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/motion/method_entry.h"
#include "engine/numbers/dual.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

// What the tangent takes of a step: M, U − I, and δU, the solution of δUΛ − ΛδUᵀ = K with K and
// UᵀδU skew, and its symmetric part S.

/// In N dimensions every symmetric S gives a solution, and UᵀδU skew fixes it:
///
///     δU = J⁻¹(K) + w∘S,   S = −½(P + Pᵀ),   P = XᵀδU,   w_ij = 2λ_i/(λ_i + λ_j).
///
/// Where the sweeps of RotationEquation do not find it, δU = Uυ with υΛU + (ΛU)ᵀυ = UᵀKU, υ skew,
/// by the Schur form of ΛU.
class StepN {
 public:
  using JDInverse = JDInverseN;
  using Square = Dense;
  static constexpr bool modified = false;

  explicit StepN(const Eigen::VectorXd& lambda)
      : lambda_(lambda), omega_(lambda.size(), lambda.size()), P_(omega_), equation_(lambda) {}

  static Square M(const Dense& x) { return x.bottomRows(x.cols()); }
  static JDInverse::State state(const Square& M) { return {M, Arithmetic::plain}; }

  /// Takes a step h from M, and sets X to U − I.
  void set(JDInverse& inverse, const JDInverse::State&, const Square& M, double h, Square& X) {
    inverse_inertia(lambda_, M, omega_);
    sine_ = std::abs(h) * equation_.norm(omega_);
    X = inverse.U_minus_I();
    lyapunov_.reset();
  }

  void differential(const Square& X, const Square& K, Square& dU, Square& S) {
    if (!(lambda_.minCoeff() < 0) && sine_ < 1 && sweep(X, K, dU, S)) return;
    Dense U = X;
    U.diagonal().array() += 1;
    if (!lyapunov_) lyapunov_.emplace(lambda_.size()).factor(lambda_.asDiagonal() * U);
    omega_.noalias() = K * U;
    S.noalias() = U.transpose() * omega_;
    lyapunov_->solve(S, S);
    S = skew_part(S);
    dU.noalias() = U * S;
    S = symmetric_part(dU);
  }

 private:
  bool sweep(const Square& X, const Square& K, Square& dU, Square& S) {
    const Index N = K.cols();
    inverse_inertia(lambda_, K, omega_);
    packed_.setZero(N * (N + 1) / 2);
    const double enough = 0x1p-53 * sine_ * omega_.cwiseAbs().maxCoeff();
    const bool found = equation_.sweep(
        sine_, enough, 64 * enough, packed_,
        [&] {
          equation_.weighted(packed_, dU, &omega_);
          P_.noalias() = X.transpose() * dU;
        },
        [&](Index j) {
          return -(P_.col(j) + P_.row(j).transpose()).head(j + 1) / 2 - packed_column(packed_, j);
        });
    equation_.weighted(packed_, dU, &omega_);
    for (Index j = 0; j < N; ++j) S.col(j).head(j + 1) = packed_column(packed_, j);
    mirror_columns(S, 0, N, 1);
    return found;
  }

  Eigen::VectorXd lambda_;
  Dense omega_, P_;
  Eigen::VectorXd packed_;  ///< S
  double sine_ = 0;         ///< h‖Ω‖
  RotationEquation equation_;
  std::optional<Lyapunov<double>> lyapunov_;  ///< of this step
};

/// In three dimensions δU = U hat(υ), (tr A − A)υ = Uᵀk, A = ΛU, K = hat(k).
template <class JDInverse_>
class Step3 {
 public:
  using JDInverse = JDInverse_;
  using Square = Eigen::Matrix3d;
  static constexpr bool modified = std::is_same_v<JDInverse, ModifiedJDInverse3<double, true>>;

  explicit Step3(const Eigen::VectorXd& lambda) : lambda_(lambda) {}

  static Square M(const auto& x) { return hat(Eigen::Vector3d(x.bottomRows(3))); }
  static auto state(const Square& M) {
    typename JDInverse::Point x;
    x << 1, 0, 0, 0, vee(M);
    return Accumulator(x, Arithmetic::plain);
  }

  void set(JDInverse&, const JDInverse::State& x, const Square&, double, Square& X) {
    // U = I + 2w v̂ + 2v̂² of the quaternion (w, v)
    const Square v = hat(x.value.template segment<3>(1));
    X = 2 * (x.value(0) * v + v * v);
    U_ = Square::Identity() + X;
    const Square A = lambda_.asDiagonal() * U_;
    of_upsilon_ = A.trace() * Square::Identity() - A;
  }

  void differential(const Square& X, const Square& K, Square& dU, Square& S) {
    const Square upsilon = hat(solve_3(of_upsilon_, U_.transpose() * vee(K)));
    dU = U_ * upsilon;
    S = symmetric_part(Square(X * upsilon));
  }

 private:
  Eigen::Vector3d lambda_;
  Square U_, of_upsilon_;  ///< U, tr A − A
};

/// Sets Λ and its derivatives to those of the modified moments J, functions of the m at the start,
/// of which dm are the derivatives.
void modify(const TangentParameters& given, int order, const Eigen::Vector3d& m,
            const Eigen::Matrix3Xd& dm, TangentParameters& at) {
  constexpr int lanes = 4;
  using Wide = Dual<long double, lanes>;
  for (Index first = 0; first < dm.cols(); first += lanes) {
    Vector3<Wide> wide_m = m.cast<Wide>(), lambda = given.lambda.cast<Wide>();
    Wide h = given.h;
    const auto width = static_cast<int>(std::min<Index>(lanes, dm.cols() - first));
    for (int k = 0; k < width; ++k) {
      for (int i = 0; i < 3; ++i) {
        wide_m(i).d[k] = dm(i, first + k);
        lambda(i).d[k] = given.by_lambda(i, first + k);
      }
      h.d[k] = given.by_h(first + k);
    }
    const BodyOfSeries<Wide> body{PrincipalMoments3<Wide>(lambda)};
    const Vector3<Wide> of_J = ModifiedSeries<Wide>(body, wide_m, order)(h).lambda();
    at.lambda = values_of(of_J).cast<double>();
    for (int k = 0; k < width; ++k) at.by_lambda.col(first + k) = lane_of(of_J, k).cast<double>();
  }
}

/// Moves (η, δM) by the steps of the discrete rigid body, Q ↦ QU, M ↦ M′, UΛ − ΛUᵀ = hM, ΛU − UᵀΛ =
/// hM′. With X = U − I and K = hδM + δhM + δΛUᵀ − UδΛ,
///
///     δUΛ − ΛδUᵀ = K,   η′ = Uᵀ(ηU + δU),
///     δM′ = δM + (2/h)((λ_i − λ_j)(S_ij − T_ij δh/h) + (δλ_i − δλ_j)T_ij),
///
/// S and T the symmetric parts of δU and X.
template <class Step>
class DiscreteBodyTangent final : public TangentMap {
 public:
  DiscreteBodyTangent(const Scene& scene, const TangentParameters& given, int order)
      : substeps_(scene.substeps()),
        order_(order),
        arithmetic_(scene.arithmetic()),
        given_(given),
        at_(given),
        gamma_(Step::modified ? std::vector{1.0} : symmetric_stages<double>(order)) {
    for (const double gamma : gamma_) {
      stop_point();
      if constexpr (Step::modified)
        branches_.emplace_back(at_.lambda, gamma * at_.h, order);
      else
        branches_.emplace_back(at_.lambda, gamma * at_.h);
    }
    const Index N = at_.lambda.size();
    for (Square* A : {&X_, &T_, &K_, &dU_, &S_}) A->setZero(N, N);
  }

  void start(const Dense& point, const Dense& V) override {
    const Index N = at_.lambda.size();
    has_frame_ = V.rows() > N * N;
    vectors_.clear();
    Eigen::Matrix3Xd dm(3, V.cols());
    for (Index v = 0; v < V.cols(); ++v) {
      stop_point();
      const Dense x = in_body(point, V.col(v));
      vectors_.push_back({{x.topRows(N), arithmetic_}, {x.bottomRows(N), arithmetic_}});
      if constexpr (Step::modified) dm.col(v) = vee(x.bottomRows(N));
    }
    M_ = Step::M(point);
    if constexpr (Step::modified) modify(given_, order_, vee(M_), dm, at_);
    step_.emplace(at_.lambda);
    differences_ = differences(at_.lambda);
    memories_.clear();
    for (std::size_t stage = 0; stage < count(); ++stage)
      memories_.push_back(branches_[folded(stage)].memory(Step::state(M_).value));
  }

  RunStatus step(const Dense& point) override {
    M_ = Step::M(point);
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < count(); ++stage) {
        const double gamma = gamma_[folded(stage)], h = gamma * at_.h;
        auto& branch = branches_[folded(stage)];
        auto x = Step::state(M_);
        if (const auto status = branch.solve(x, memories_[stage]); !status.reached()) return status;
        branch.inverse().transport(x, memories_[stage]);
        step_->set(branch.inverse(), x, M_, h, X_);
        T_ = symmetric_part(X_);
        for (Index v = 0; v < std::ssize(vectors_); ++v) move(v, h, gamma * at_.by_h(v));
        M_ = Step::M(x.value);
      }
    return {};
  }

  void read(const Dense& point, Dense& V) const override {
    const Index N = at_.lambda.size();
    Dense x(V.rows() / N, N);
    for (Index v = 0; v < V.cols(); ++v) {
      stop_point();
      const Vector& vector = vectors_[static_cast<std::size_t>(v)];
      x.bottomRows(N) = vector.m.value;
      if (has_frame_) x.topRows(N) = vector.eta.value;
      V.col(v) = in_space(point, x);
    }
  }

 private:
  using Square = typename Step::Square;
  using Branch = PrincipalBranch<typename Step::JDInverse>;
  struct Vector {
    Accumulator<Square> eta, m;
  };

  std::size_t count() const { return 2 * gamma_.size() - 1; }
  std::size_t folded(std::size_t stage) const { return std::min(stage, count() - 1 - stage); }

  /// Returns λ_i − λ_j.
  static Square differences(const Eigen::VectorXd& lambda) {
    const Dense columns = lambda.replicate(1, lambda.size());
    return columns - columns.transpose();
  }

  void move(Index v, double h, double dh) {
    auto& [eta, m] = vectors_[static_cast<std::size_t>(v)];
    const bool varies = !at_.constant(v);
    stop_point(3 * static_cast<double>(X_.rows() * X_.size()));
    K_ = h * m.value;
    if (varies) {
      S_ = X_ * at_.by_lambda.col(v).asDiagonal();
      K_ += dh * M_ + S_.transpose() - S_;
    }
    step_->differential(X_, K_, dU_, S_);
    if (varies) S_ -= dh / h * T_;
    K_ = differences_.cwiseProduct(S_);
    if (varies) K_ += differences(at_.by_lambda.col(v)).cwiseProduct(T_);
    m.add(2 / h * K_);
    if (!has_frame_) return;
    // η′ − η = A + XᵀB, A = ηX + δU, B = η + A
    dU_.noalias() += eta.value * X_;
    K_ = eta.value + dU_;
    S_.noalias() = X_.transpose() * K_;
    S_ += dU_;
    eta.add(skew_part(S_));
  }

  int substeps_, order_;
  Arithmetic arithmetic_;
  bool has_frame_ = false;
  TangentParameters given_, at_;  ///< of Λ, and of the Λ that the steps have
  std::vector<double> gamma_;
  std::vector<Branch> branches_;
  std::vector<typename Branch::Memory> memories_;  ///< of the stages
  std::optional<Step> step_;
  Square differences_, M_, X_, T_, K_, dU_, S_;  ///< M, U − I and its symmetric part, of a stage
  std::vector<Vector> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const TangentParameters& at) {
  const bool modified = scene.method() == method_name::preprocessed;
  const MethodEntry* method = method_entry(scene.method());
  const int order = scene.order() > 0 ? scene.order() : method ? method->traits.default_order : 2;
  if (modified)
    return std::make_unique<DiscreteBodyTangent<Step3<ModifiedJDInverse3<double, true>>>>(scene, at,
                                                                                          order);
  if (scene.dimension() == 3)
    return std::make_unique<DiscreteBodyTangent<Step3<JDInverse3<double, true>>>>(scene, at, order);
  return std::make_unique<DiscreteBodyTangent<StepN>>(scene, at, order);
}

}  // namespace stiefel
