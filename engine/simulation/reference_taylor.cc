// Taylor series in quadruple and extended precision.
#include "engine/linalg/quadruple.h"
#include "engine/problems/taylor_motion.h"
#include "engine/problems/taylor_rigid_body.h"
#include "engine/problems/taylor_stiefel.h"
#include "engine/simulation/conversion.h"
#include "engine/simulation/reference.h"

namespace stiefel {
namespace {

/// How the same motion is reported by the scene it is a reference for.
struct Presentation {
  bool right = false;  ///< Qᵀ and −M, [RB] Prop. 2.1
  std::optional<PrincipalAxes> axes = {};
  double start_error = 0;  ///< of the conversion to (Q, M) or (Q, S)

  /// A state in rows: the frame, then the momentum.
  MotionState of(const Matrix<long double>& x, Eigen::Index momentum_rows) const {
    MotionState state{x.topRows(x.rows() - momentum_rows), x.bottomRows(momentum_rows)};
    if (right) {
      state.attitude.transposeInPlace();
      state.momentum *= -1;
    }
    if (axes) {
      const Matrix<long double> R = axes->rotation.cast<long double>();
      state.attitude = (state.attitude * R.transpose()).eval();
      state.momentum = (R * state.momentum * R.transpose()).eval();
    }
    return state;
  }
};

/// Units of work an operation takes: instructions of the software that adds or multiplies.
template <class Scalar>
constexpr double operation_work = std::is_same_v<Scalar, Quad> ? 80 : 8;
/// What a series may leave out in each precision.
constexpr double quadruple_epsilon = 1e-26, extended_epsilon = 1e-18;
/// How much coarser the second solution is, whose distance from the first is the error.
constexpr double coarser = 1e4;

template <class Series>
class TaylorReference final : public Reference {
 public:
  using Scalar = typename Series::Scalar;

  /// `make(order)` is the series.
  template <class Make>
  TaylorReference(Make make, const Matrix<double>& x, double epsilon, double budget,
                  Presentation presentation)
      : presentation_(std::move(presentation)),
        budget_(budget),
        order_(taylor_order(epsilon)),
        work_(series_work(x, order_)),
        coarse_work_(series_work(x, taylor_order(coarser * epsilon))),
        momentum_rows_(make(order_).momentum_rows()),
        fine_(make(order_), x.template cast<Scalar>(), epsilon),
        coarse_(make(taylor_order(coarser * epsilon)), x.template cast<Scalar>(),
                coarser * epsilon) {}

  static double series_work(const Matrix<double>& x, int order) {
    return operation_work<Scalar> * Series::operations(x.rows(), x.cols(), order);
  }

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    const auto stopped = [&] { return stop.stop_requested() || work() > budget_; };
    if (!fine_.go_to(time, stopped) || !coarse_.go_to(time, stopped)) return std::nullopt;
    MotionState state = present(fine_);
    constexpr double rounding = std::numeric_limits<long double>::epsilon();
    error_ = std::max({error_, rounding, error_of(present(coarse_), state).largest()});
    return Answer{std::move(state), error_ + presentation_.start_error};
  }

  std::string description() const override {
    return "Taylor series of order " + std::to_string(order_) +
           (std::is_same_v<Scalar, Quad> ? " in quadruple precision" : " in extended precision");
  }

  double work() const override {
    return static_cast<double>(fine_.series_count()) * work_ +
           static_cast<double>(coarse_.series_count()) * coarse_work_;
  }

  /// By the stretches that the first series span; before those, two series that are dearer than the
  /// budget are dear enough.
  std::optional<double> predicted_work(double time, const std::stop_token& stop) override {
    const double first = work_ + coarse_work_;
    const auto stopped = [&] { return stop.stop_requested(); };
    if (first > budget_ || !fine_.go_to(0, stopped) || !coarse_.go_to(0, stopped)) return first;
    const auto stretches = [&](const auto& motion) {
      return std::max(1.0, std::ceil(std::abs(time) / motion.span()));
    };
    return stretches(fine_) * work_ + stretches(coarse_) * coarse_work_;
  }

 private:
  MotionState present(const TaylorMotion<Series>& motion) const {
    return presentation_.of(motion.state().template cast<long double>(), momentum_rows_);
  }

  Presentation presentation_;
  double budget_;
  int order_;
  double work_, coarse_work_;
  Eigen::Index momentum_rows_;
  TaylorMotion<Series> fine_, coarse_;
  double error_ = 0;
};

/// A scene of rigid_body or stiefel with the same motion, and how to go back.
struct Canonical {
  Scene scene;
  Presentation presentation;
};

std::optional<Canonical> canonical(const Scene& scene) {
  const std::string& system = scene.system();
  Presentation presentation{system.starts_with("right_"), scene.axes()};
  if (system == "rigid_body" || system == "stiefel") return Canonical{scene, presentation};
  if (system.starts_with("parametric")) return std::nullopt;  // its Q is not orthogonal for long
  const bool frames = system.starts_with("stiefel") || system == "ellipsoid";
  auto converted = convert(scene, {frames ? "stiefel" : "rigid_body"});
  if (!converted || !converted->scene) return std::nullopt;
  presentation.start_error = 0x1p-51;
  return Canonical{*std::move(converted->scene), presentation};
}

/// The same in quadruple precision if that stays within the budget, else in extended.
template <template <class> class Series, class Make>
std::unique_ptr<Reference> affordable(const Make& make, const Matrix<double>& x,
                                      const ReferenceNeed& need, const Presentation& presentation) {
  const auto made = [&]<class Scalar>(Scalar, double epsilon) {
    return std::make_unique<TaylorReference<Series<Scalar>>>(
        [&](int order) { return make(Scalar(), order); }, x, epsilon, need.budget, presentation);
  };
  if (need.quadruple) {
    // Extended precision says how far a series reaches.
    const int order = taylor_order(quadruple_epsilon);
    TaylorMotion<Series<long double>> probe(make(0.0L, order), x.cast<long double>(),
                                            quadruple_epsilon);
    probe.go_to(0, [] { return false; });
    const double stretches = std::ceil(std::abs(need.time) / probe.span());
    if (2 * stretches * TaylorReference<Series<Quad>>::series_work(x, order) <= need.budget)
      return made(Quad(), quadruple_epsilon);
  }
  return made(0.0L, extended_epsilon);
}

}  // namespace

std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need) {
  const auto same = canonical(scene);
  if (!same) return nullptr;
  const auto& [body, presentation] = *same;
  const Eigen::VectorXd& lambda = body.inertia();
  const Matrix<double>& Q = body.Q();
  if (body.system() == "stiefel") {
    const Matrix<double>& S = body.block("S");
    Matrix<double> x(2 * Q.rows(), Q.cols());
    x << Q, S;
    const auto make = [&]<class Scalar>(Scalar, int order) {
      return TaylorStiefel<Scalar>(lambda.cast<Scalar>(), Q.rows(), order);
    };
    return affordable<TaylorStiefel>(make, x, need, presentation);
  }
  const Matrix<double>& M = body.M();
  Matrix<double> x(Q.rows() + M.rows(), M.cols());
  x << Q, M;
  const auto make = [&]<class Scalar>(Scalar, int order) {
    return TaylorRigidBody<Scalar>(lambda.cast<Scalar>(), order);
  };
  return affordable<TaylorRigidBody>(make, x, need, presentation);
}

}  // namespace stiefel
