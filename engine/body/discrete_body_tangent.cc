#include "engine/body/moser_veselov.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/body/rigid_tangents.h"
#include "engine/dense/so_3.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/methods/variational.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/dual.h"
#include "engine/numbers/pair.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// Tangent vectors of a left-invariant body, (η, δM) with δQ = Qη, by their elements i < j, in
/// pairs. N is the dimension where it is fixed, else Eigen::Dynamic.
template <int N>
class BodyColumns {
 public:
  static constexpr int d = N > 0 ? N*(N - 1) / 2 : Eigen::Dynamic;

  /// Returns the number of elements i < j, and the place of one.
  static constexpr Index size(Index n) { return n * (n - 1) / 2; }
  static constexpr Index at(Index i, Index j) { return j * (j - 1) / 2 + i; }

  BodyColumns(Index n, Arithmetic arithmetic) : n_(n), arithmetic_(arithmetic) {}

  using Elements = Eigen::Matrix<Pair, d, 1>;
  /// Two vectors.
  struct Two {
    Accumulator<Elements> eta, m;
  };
  std::vector<Two>& pairs() { return pairs_; }
  const std::vector<Two>& pairs() const { return pairs_; }
  bool has_frame() const { return has_frame_; }

  /// Takes vectors, which are blocks, at a point of Observables.
  void set(const Dense& point, const Dense& V) {
    const Index rows = V.rows() / n_;
    has_frame_ = rows > n_;
    const Accumulator<Elements> zero(Elements::Constant(size(n_), Pair(0)), arithmetic_);
    pairs_.assign(static_cast<std::size_t>((V.cols() + 1) / 2), {zero, zero});
    const Dense Q = has_frame_ ? frame(point) : Dense();
    for (Index v = 0; v < V.cols(); ++v) {
      Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      const Dense block = V.col(v).reshaped(rows, n_);
      write(block.bottomRows(n_), v % 2, x.m.value);
      if (has_frame_) write(Q.transpose() * block.topRows(n_), v % 2, x.eta.value);
    }
  }

  void read(const Dense& point, Dense& V) const {
    const Index rows = V.rows() / n_;
    const Dense Q = has_frame_ ? frame(point) : Dense();
    for (Index v = 0; v < V.cols(); ++v) {
      const Two& x = pairs_[static_cast<std::size_t>(v / 2)];
      auto block = V.col(v).reshaped(rows, n_);
      block.bottomRows(n_) = matrix(x.m.value, v % 2);
      if (has_frame_) block.topRows(n_) = Q * matrix(x.eta.value, v % 2);
    }
  }

 private:
  /// Returns Q at a point, which in three dimensions has it as a quaternion.
  static Dense frame(const Dense& point) {
    if constexpr (N == 3)
      return rotation_matrix<double>(Eigen::Vector4d(point.topRows(4)));
    else
      return point.topRows(point.cols());
  }
  void write(const Dense& A, Index lane, Elements& out) const {
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i)
        out(at(i, j)).set(static_cast<int>(lane), (A(i, j) - A(j, i)) / 2);
  }
  Dense matrix(const Elements& x, Index lane) const {
    Dense A = Dense::Zero(n_, n_);
    for (Index j = 0; j < n_; ++j)
      for (Index i = 0; i < j; ++i) {
        A(i, j) = x(at(i, j))[static_cast<int>(lane)];
        A(j, i) = -A(i, j);
      }
    return A;
  }

  Index n_;
  Arithmetic arithmetic_;
  bool has_frame_ = false;
  std::vector<Two> pairs_;
};

/// The linear maps of one step Q ↦ QU, M ↦ M′ = UᵀMU on elements i < j.
template <int N>
class RotationOfColumns {
 public:
  using Columns = BodyColumns<N>;
  static constexpr int d = Columns::d;
  using Square = Eigen::Matrix<double, N, N>;
  using Operator = Eigen::Matrix<double, d, d>;
  using Elements = typename Columns::Elements;

  explicit RotationOfColumns(Index n)
      : rows_(n, n),
        turned_(n, n),
        turn_(Columns::size(n), Columns::size(n)),
        bracket_(turn_.rows(), turn_.rows()) {}

  /// Takes D = U − I and M′.
  void set(const Square& D, const Square& M1) {
    rows_ = D.transpose();
    turned_ = D;
    turned_.diagonal().array() += 1;
    set_turn(D);
    const Index n = D.rows();
    bracket_.setZero();
    for (Index j = 0; j < n; ++j)
      for (Index i = 0; i < j; ++i)
        for (Index k = 0; k < n; ++k) {
          add(bracket_, Columns::at(i, j), k, j, M1(i, k));
          add(bracket_, Columns::at(i, j), i, k, -M1(k, j));
        }
  }

  /// Adds the coefficient of element (k, l) of a skew matrix to a row of an operator on elements.
  template <class Matrix>
  static void add(Matrix& A, Index row, Index k, Index l, double value) {
    if (k < l) A(row, Columns::at(k, l)) += value;
    if (k > l) A(row, Columns::at(l, k)) -= value;
  }

  /// Adds UᵀXU − X.
  void add_turn(const Elements& x, Elements& sum) const { add_product(turn_, x, sum); }
  /// Adds [M′, υ].
  void add_bracket(const Elements& upsilon, Elements& sum) const {
    add_product(bracket_, upsilon, sum);
  }

 private:
  /// Sets the element (i, j), (k, l) to U_ki U_lj − U_li U_kj − δ_ki δ_lj without cancellation.
  void set_turn(const Square& D) {
    const Index n = D.rows();
    double* out = turn_.data();
    for (Index l = 0; l < n; ++l)
      for (Index k = 0; k < l; ++k, out += turn_.rows()) {
        const double *of_k = rows_.data() + n * k, *of_l = rows_.data() + n * l;
        for (Index j = 0; j < n; ++j) {
          const double a = turned_(l, j), b = turned_(k, j);
          double* const column = out + Columns::at(0, j);
          for (Index i = 0; i < j; ++i) column[i] = of_k[i] * a - of_l[i] * b;
          if (k < j) column[k] += D(l, j);
          if (l < j) column[l] -= b;
        }
      }
  }
  static void add_product(const Operator& A, const Elements& x, Elements& sum) {
    const Index size = A.rows();
    const double* a = A.data();
    Pair* const to = sum.data();
    for (Index k = 0; k < size; ++k)
      for (Index i = 0; i < size; ++i) to[i] += Pair(*a++) * x(k);
  }

  Square rows_, turned_;  ///< Dᵀ and U
  Operator turn_, bracket_;
};

/// Turns U into D = U − I, whose diagonal follows from its other elements: 2D_jj = −Σ_i D_ij².
template <class Square>
void subtract_identity(Square& U) {
  for (Index j = 0; j < U.cols(); ++j) {
    U(j, j) -= 1;
    U(j, j) = -U.col(j).squaredNorm() / 2;
  }
}

/// The values of a step from (I, M): U − I and M′, and conversions of M.
template <class Space>
struct Turned;

template <>
struct Turned<So3<double, true>> {
  static constexpr int N = 3;
  using Point = So3<double, true>::State;
  using Square = Eigen::Matrix3d;

  static Square M(const Dense& point) { return hat(Eigen::Vector3d(point.bottomRows(3))); }
  static void set(const Square& M, Point& x) { x << 1, 0, 0, 0, vee(M); }
  static void get(const Accumulator<Point>& x, Square& D, Square& M) {
    // U = I + 2w v̂ + 2v̂² of the quaternion (w, v)
    const Eigen::Vector4d q = x.value.head<4>();
    const Square v = hat(q.tail<3>());
    D = 2 * (q(0) * v + v.lazyProduct(v));
    M = hat(x.value.tail<3>());
  }
};

template <>
struct Turned<So4<double, true>> {
  static constexpr int N = 4;
  using Point = So4<double, true>::State;
  using Square = Eigen::Matrix4d;

  static Square M(const Dense& point) { return point.bottomRows(4); }
  static void set(const Square& M, Point& x) {
    x.head<16>() = Square::Identity().reshaped();
    for (int k = 0; k < 6; ++k) x(16 + k) = M(skew4_rows[k], skew4_columns[k]);
  }
  static void get(const Accumulator<Point>& x, Square& D, Square& M) {
    D.reshaped() = x.value.head<16>();
    subtract_identity(D);
    for (int k = 0; k < 6; ++k) {
      M(skew4_rows[k], skew4_columns[k]) = x.value(16 + k);
      M(skew4_columns[k], skew4_rows[k]) = -x.value(16 + k);
    }
    M.diagonal().setZero();
  }
};

template <>
struct Turned<SoN<double>> {
  static constexpr int N = Eigen::Dynamic;
  using Point = Dense;
  using Square = Dense;

  static Square M(const Dense& point) { return point.bottomRows(point.cols()); }
  static void set(const Square& M, Point& x) {
    x.resize(2 * M.rows(), M.rows());
    x.topRows(M.rows()).setIdentity();
    x.bottomRows(M.rows()) = M;
  }
  static void get(const Accumulator<Point>& x, Square& D, Square& M) {
    const Index N = x.value.cols();
    D = x.value.topRows(N);
    subtract_identity(D);
    M = x.value.bottomRows(N);
  }
};

/// The discrete bodies as stages of a step, with the Λ of their equation UΛ − ΛUᵀ = hM.
template <class Space>
struct Stages {
  using Map = MoserVeselov<Space>;
  Stages(const Scene& scene, const TangentParameters& at)
      : gamma(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        lambda(at.lambda),
        by_lambda(at.by_lambda) {
    for (const double g : gamma) maps.emplace_back(at.lambda, g * at.h, Arithmetic::plain);
  }
  /// For vectors at a momentum.
  void start(const Eigen::MatrixXd&, const Eigen::MatrixXd&) {}

  std::vector<double> gamma;
  std::vector<Map> maps;
  Eigen::VectorXd lambda;
  Dense by_lambda;
};

/// Λ and its derivatives are those of the modified moments J, functions of the m at the start.
struct ModifiedStage {
  using Map = PreprocessedMoserVeselov<double, true>;
  static constexpr int lanes = 4;
  using Wide = Dual<long double, lanes>;

  ModifiedStage(const Scene& scene, const TangentParameters& given)
      : order(scene.order() > 0 ? scene.order() : PreprocessedVariational::traits.default_order),
        at(given),
        by_lambda(given.by_lambda) {
    maps.emplace_back(at.lambda, at.h, Arithmetic::plain, order);
  }
  void start(const Dense& M, const Dense& V) {
    for (Index first = 0; first < V.cols(); first += lanes) {
      Vector3<Wide> m = vee(M).cast<Wide>(), l = at.lambda.cast<Wide>();
      Wide h = at.h;
      const Index width = std::min<Index>(lanes, V.cols() - first);
      for (Index k = 0; k < width; ++k) {
        const auto lane = static_cast<int>(k);
        const Index v = first + k;
        const Eigen::Vector3d dm = vee(V.col(v).reshaped(V.rows() / 3, 3).bottomRows(3));
        for (int i = 0; i < 3; ++i) {
          m(i).d[lane] = dm(i);
          l(i).d[lane] = at.by_lambda(i, v);
        }
        h.d[lane] = at.by_h(v);
      }
      const Vector3<Wide> of_J =
          ModifiedSeries<Wide>(PrincipalMoments3<Wide>(l), m, order)(h).lambda();
      lambda = values_of(of_J).cast<double>();
      for (Index k = 0; k < width; ++k)
        by_lambda.col(first + k) = lane_of(of_J, static_cast<int>(k)).cast<double>();
    }
  }

  int order;
  TangentParameters at;
  std::vector<double> gamma = {1};
  std::vector<Map> maps;
  Eigen::VectorXd lambda;
  Dense by_lambda;
};

/// Moves (η, δM) by steps Q ↦ QU, M ↦ M′ = UᵀMU with UΛ − ΛUᵀ = hM: δU = Uυ, A = ΛU,
///
///     υA + Aᵀυ = hUᵀδMU + δh M′ + UᵀδΛ − δΛU,
///     η′ = UᵀηU + υ,   δM′ = UᵀδMU + [M′, υ].
template <class Space, class Stages>
class DiscreteBodyTangent final : public TangentMap {
 public:
  DiscreteBodyTangent(const Scene& scene, const TangentParameters& at)
      : substeps_(scene.substeps()),
        N_(scene.dimension()),
        parameters_(at),
        stages_(scene, at),
        columns_(N_, scene.arithmetic()),
        rotation_(N_),
        lu_(static_cast<std::size_t>(Columns::size(N_))),
        D_(N_, N_),
        M_(N_, N_),
        upsilon_(Columns::size(N_)),
        sum_(Columns::size(N_)) {}

  void start(const Dense& point, const Dense& V) override {
    columns_.set(point, V);
    M_ = Values::M(point);
    stages_.start(M_, V);
    typename Values::Point x;
    Values::set(M_, x);
    states_.clear();
    for (std::size_t stage = 0; stage < count(); ++stage)
      states_.push_back(stages_.maps[folded(stage)].start(x));
    varies_.assign(columns_.pairs().size(), false);
    for (Index v = 0; v < V.cols(); ++v)
      if (!stages_.by_lambda.col(v).isZero(0) || parameters_.by_h(v) != 0)
        varies_[static_cast<std::size_t>(v / 2)] = true;
  }

  RunStatus step(const Dense& point) override {
    M_ = Values::M(point);
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < count(); ++stage) {
        auto& state = states_[stage];
        Values::set(M_, state.x.value);
        if (const auto status = stages_.maps[folded(stage)].step(state); !status.reached())
          return status;
        Values::get(state.x, D_, M_);
        move(stages_.gamma[folded(stage)]);
      }
    return {};
  }
  void read(const Dense& point, Dense& V) const override { columns_.read(point, V); }

 private:
  using Values = Turned<Space>;
  using Columns = BodyColumns<Values::N>;
  using Rotation = RotationOfColumns<Values::N>;

  std::size_t count() const { return 2 * stages_.gamma.size() - 1; }
  std::size_t folded(std::size_t stage) const { return std::min(stage, count() - 1 - stage); }
  double U(Index i, Index j) const { return (i == j ? 1 : 0) + D_(i, j); }

  void move(double gamma) {
    const Index size = Columns::size(N_);
    stop_point(static_cast<double>(size * size * size) / 3);
    rotation_.set(D_, M_);
    lu_.set_zero();
    for (Index j = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i)
        for (Index k = 0; k < N_; ++k) {
          Rotation::add(lu_, Columns::at(i, j), i, k, stages_.lambda(k) * U(k, j));
          Rotation::add(lu_, Columns::at(i, j), k, j, stages_.lambda(k) * U(k, i));
        }
    lu_.factor();
    const Pair h = gamma * parameters_.h;
    for (std::size_t p = 0; p < columns_.pairs().size(); ++p) {
      stop_point(8 * static_cast<double>(size * size));
      auto& x = columns_.pairs()[p];
      sum_.setConstant(Pair(0));
      rotation_.add_turn(x.m.value, sum_);
      upsilon_ = h * (x.m.value + sum_);
      if (varies_[p]) add_parameters(p, gamma);
      lu_.solve(upsilon_.data());
      rotation_.add_bracket(upsilon_, sum_);
      x.m.add(sum_);
      if (!columns_.has_frame()) continue;
      rotation_.add_turn(x.eta.value, upsilon_);
      x.eta.add(upsilon_);
    }
  }

  void add_parameters(std::size_t p, double gamma) {
    const auto first = static_cast<Index>(2 * p), last = stages_.by_lambda.cols() - 1;
    const auto pair = [&](const auto& row) {
      return Pair::of_lanes([&](int k) { return first + k <= last ? row(first + k) : 0; });
    };
    const Pair dh = Pair(gamma) * pair(parameters_.by_h);
    for (Index j = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i)
        upsilon_(Columns::at(i, j)) += dh * Pair(M_(i, j)) +
                                       pair(stages_.by_lambda.row(j)) * Pair(U(j, i)) -
                                       pair(stages_.by_lambda.row(i)) * Pair(U(i, j));
  }

  int substeps_;
  Index N_;
  TangentParameters parameters_;
  Stages stages_;
  Columns columns_;
  Rotation rotation_;
  PairLu lu_;
  std::vector<typename Stages::Map::State> states_;
  std::vector<bool> varies_;
  typename Values::Square D_, M_;  ///< U − I and M′ of the last stage
  typename Columns::Elements upsilon_, sum_;
};

template <class Space, template <class> class Stages>
std::unique_ptr<TangentMap> made(const Scene& scene, const TangentParameters& at) {
  return std::make_unique<DiscreteBodyTangent<Space, Stages<Space>>>(scene, at);
}

}  // namespace

std::unique_ptr<TangentMap> discrete_body_tangent(const Scene& scene, const TangentParameters& at) {
  constexpr Index largest_by_elements = 10;
  if (scene.method() == PreprocessedVariational::traits.name)
    return std::make_unique<DiscreteBodyTangent<So3<double, true>, ModifiedStage>>(scene, at);
  if (scene.dimension() > largest_by_elements) return large_body_tangent(scene, at);
  if (scene.dimension() == 3) return made<So3<double, true>, Stages>(scene, at);
  if (scene.dimension() == 4) return made<So4<double, true>, Stages>(scene, at);
  return made<SoN<double>, Stages>(scene, at);
}

}  // namespace stiefel
