// Taylor series in quadruple and extended precision as references.
#include <algorithm>
#include <cmath>

#include "engine/accuracy/presentation.h"
#include "engine/accuracy/series_equations.h"
#include "engine/catalogue/system_entry.h"
#include "engine/double_bracket/taylor_double_bracket.h"
#include "engine/frames/body/taylor_stiefel.h"
#include "engine/linalg/special_functions/taylor_motion.h"
#include "engine/numbers/quadruple.h"
#include "engine/parametric/taylor_parametric_rigid_body.h"
#include "engine/rigid_body/body/taylor_rigid_body.h"

namespace stiefel {
namespace {

/// Units of work of an operation: the instructions of an addition or a multiplication, in quadruple
/// precision of the software that makes them.
template <class Scalar>
constexpr double operation_work = std::is_same_v<Scalar, Quad> ? 80 : 8;
/// Relative truncation error of a series in each precision.
constexpr double quadruple_epsilon = 1e-26, extended_epsilon = 1e-18;
/// Factor by which the truncation error of the second solution exceeds that of the first. The
/// distance of the two is the error estimate. The second solution has series of a lower order and
/// of another length. In extended precision the factor is small, so that over thousands of series
/// the estimate stays below the tolerances that double precision can meet.
template <class Scalar>
constexpr double coarser = std::is_same_v<Scalar, Quad> ? 1e4 : 1e2;

template <class Series>
class TaylorReference final : public Reference {
 public:
  using Scalar = typename Series::Scalar;

  /// `make(order)` returns the series.
  template <class Make>
  TaylorReference(Make make, const SeriesStart<Scalar>& start, double epsilon, double budget)
      : presentation_(start.presentation),
        budget_(budget),
        order_(taylor_order(epsilon)),
        work_(series_work(start.x.rows(), start.x.cols(), order_)),
        coarse_work_(series_work(start.x.rows(), start.x.cols(), coarse_order(epsilon))),
        momentum_rows_(make(order_).momentum_rows()),
        fine_(make(order_), start.x, epsilon),
        coarse_(make(coarse_order(epsilon)), perturbed_by_rounding(start.x, momentum_rows_, order_),
                coarser<Scalar> * epsilon) {}

  static double series_work(Eigen::Index rows, Eigen::Index cols, int order) {
    return operation_work<Scalar> * Series::operations(rows, cols, order);
  }

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    // Begins no series that exceeds the budget.
    const auto before = [&](double series) {
      return [&, series] { return stop.stop_requested() || work() + series > budget_; };
    };
    if (!fine_.go_to(time, before(work_)) || !coarse_.go_to(time, before(coarse_work_)))
      return std::nullopt;
    ++answers_;
    MotionState state = present(fine_);
    error_ = std::max({error_, rounding(state), error_of(present(coarse_), state).largest()});
    return Answer{std::move(state), error_};
  }

  std::string description() const override {
    return "Taylor series of order " + std::to_string(order_) +
           (std::is_same_v<Scalar, Quad> ? " in quadruple precision" : " in extended precision");
  }

  double work() const override {
    return static_cast<double>(fine_.series_count()) * work_ +
           static_cast<double>(coarse_.series_count()) * coarse_work_ + answers_ * answer_work();
  }
  /// Both series by Horner's rule, two operations for each coefficient of each number.
  double answer_work() const override {
    return operation_work<Scalar> * 4 * order_ * static_cast<double>(fine_.state().size());
  }

  /// Predicts the work from the time that the first series spans. If the first series of both
  /// solutions already exceed the budget, returns their work.
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
  /// Returns the start of the second solution, which in extended precision has a momentum larger by
  /// `order` roundings. The start and its first series are rounded in the same way in both
  /// solutions, so only a changed start shows what the motion makes of that rounding.
  static Matrix<Scalar> perturbed_by_rounding(Matrix<Scalar> x, Eigen::Index momentum_rows,
                                              int order) {
    if constexpr (std::is_same_v<Scalar, long double>)
      x.bottomRows(momentum_rows) *= 1 + order * std::numeric_limits<Scalar>::epsilon();
    return x;
  }
  static int coarse_order(double epsilon) { return taylor_order(coarser<Scalar> * epsilon); }

  MotionState present(const TaylorMotion<Series>& motion) const {
    return stiefel::present(presentation_, motion.state(), momentum_rows_);
  }

  /// Returns a bound on the rounding error, which the two solutions may have in common. A series in
  /// extended precision is a sum of `order` rounded terms, one in quadruple precision is rounded
  /// once, when it is reported; each rounding is relative to the largest number on the way to the
  /// result.
  double rounding(const MotionState& state) const {
    constexpr double unit = std::numeric_limits<long double>::epsilon();
    const double terms = std::is_same_v<Scalar, Quad> ? 1 : order_;
    const auto largest = [](const auto& A) {
      return A.size() > 0 ? static_cast<double>(A.cwiseAbs().maxCoeff()) : 0;
    };
    const double momentum = largest(state.momentum),
                 computed = largest(fine_.state().bottomRows(momentum_rows_));
    const double part = momentum > 0 ? computed / momentum : 1;
    return terms * unit * std::max({1.0, largest(state.attitude), part});
  }

  Presentation<Scalar> presentation_;
  double budget_;
  int order_;
  double work_, coarse_work_;
  Eigen::Index momentum_rows_;
  TaylorMotion<Series> fine_, coarse_;
  double error_ = 0, answers_ = 0;
};

/// Returns the reference in quadruple precision if that stays within the budget, else in extended.
/// `make(start, order)` returns the series of a start in either precision.
template <class Make>
std::unique_ptr<Reference> affordable(const Make& make, const Scene& scene,
                                      const SeriesStart<long double>& start,
                                      const ReferenceNeed& need) {
  const auto made = [&](const auto& from, double epsilon) -> std::unique_ptr<Reference> {
    using Series = decltype(make(from, 1));
    return std::make_unique<TaylorReference<Series>>([&](int order) { return make(from, order); },
                                                     from, epsilon, need.budget);
  };
  const int order = taylor_order(quadruple_epsilon);
  using QuadrupleSeries = decltype(make(SeriesStart<Quad>(), 1));
  const double work =
      2 * TaylorReference<QuadrupleSeries>::series_work(start.x.rows(), start.x.cols(), order);
  if (need.quadruple && work <= need.budget) {
    // A series in extended precision shows how far a series reaches.
    TaylorMotion probe(make(start, order), start.x, quadruple_epsilon);
    probe.go_to(0, [] { return false; });
    if (std::ceil(std::abs(need.time) / probe.span()) * work <= need.budget)
      return made(system_entry(scene.system())->motion->quadruple(scene), quadruple_epsilon);
  }
  return made(start, extended_epsilon);
}

}  // namespace

std::unique_ptr<Reference> taylor_rigid_body(const Scene& scene,
                                             const SeriesStart<long double>& start,
                                             const ReferenceNeed& need) {
  const auto make = []<class Scalar>(const SeriesStart<Scalar>& s, int order) {
    return TaylorRigidBody<Scalar>(s.lambda, order);
  };
  return affordable(make, scene, start, need);
}

std::unique_ptr<Reference> taylor_parametric_rigid_body(const Scene& scene,
                                                        const SeriesStart<long double>& start,
                                                        const ReferenceNeed& need) {
  const auto make = []<class Scalar>(const SeriesStart<Scalar>& s, int order) {
    return TaylorParametricRigidBody<Scalar>(s.lambda, s.mu, order);
  };
  return affordable(make, scene, start, need);
}

std::unique_ptr<Reference> taylor_stiefel(const Scene& scene, const SeriesStart<long double>& start,
                                          const ReferenceNeed& need) {
  const auto make = []<class Scalar>(const SeriesStart<Scalar>& s, int order) {
    return TaylorStiefel<Scalar>(s.lambda, s.x.rows() / 2, order);
  };
  return affordable(make, scene, start, need);
}

std::unique_ptr<Reference> taylor_double_bracket(const Scene& scene,
                                                 const SeriesStart<long double>& start,
                                                 const ReferenceNeed& need) {
  const auto make = []<class Scalar>(const SeriesStart<Scalar>& s, int order) {
    return TaylorDoubleBracket<Scalar>(s.lambda, s.lambda_v, order);
  };
  return affordable(make, scene, start, need);
}

std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need) {
  const MotionStart* motion = system_entry(scene.system())->motion;
  if (motion == nullptr) return nullptr;
  const SeriesStart<long double> start = motion->extended(scene);
  return start.equations->taylor(scene, start, need);
}

}  // namespace stiefel

namespace stiefel::series_equations {

constinit const SeriesEquations rigid_body = {taylor_rigid_body, closed_form_of_body};
constinit const SeriesEquations parametric_rigid_body = {taylor_parametric_rigid_body};
constinit const SeriesEquations stiefel = {taylor_stiefel, closed_form_of_geodesic};
constinit const SeriesEquations double_bracket = {taylor_double_bracket};

}  // namespace stiefel::series_equations
