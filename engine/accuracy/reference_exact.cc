// The closed forms as references.
#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/accuracy/presentation.h"
#include "engine/accuracy/series_equations.h"
#include "engine/catalogue/system_entry.h"
#include "engine/frames/geodesics/isotropic_geodesic.h"
#include "engine/numbers/quadruple.h"
#include "engine/rigid_body/exact/euler_top.h"
#include "engine/rigid_body/exact/two_valued_body.h"

namespace stiefel {
namespace {

using Solution = std::function<MotionState(double)>;

/// One closed form in two precisions. The distance of the two solutions is the error of the coarser
/// one; the error of the finer one is smaller by the ratio of their roundings.
struct ClosedForm {
  Solution fine, coarse;
  struct Precision {
    /// Bound of the error of the fine solution divided by the distance, with some bits to spare.
    double finer;
    double unit;  ///< rounding error of an angle of 1
  } precision;
  double rate;  ///< ‖Ω‖_F or ‖Q̇‖_F, 1/time
  double work;  ///< work of a state in both precisions
  std::string description;
  double start = 0;  ///< distance of Q from its manifold, on which the closed form is the motion
};

constexpr ClosedForm::Precision in_quadruple = {0x1p-40, 0x1p-111};  // 113 bits against 64 bits
constexpr ClosedForm::Precision in_extended = {0x1p-6, 0x1p-62};     // 64 bits against 53 bits
/// A distance of at least this size is not proportional to the rounding any more.
constexpr double proportional = 0x1p-10;

double distance(const MotionState& a, const MotionState& b) {
  const bool finite = a.attitude.allFinite() && b.attitude.allFinite() && a.momentum.allFinite() &&
                      b.momentum.allFinite();
  return finite ? error_of(a, b).largest() : std::numeric_limits<double>::infinity();
}

class ExactReference final : public Reference {
 public:
  ExactReference(ClosedForm form, double budget) : form_(std::move(form)), budget_(budget) {}

  /// Whether the error estimate holds at the time.
  bool holds_at(double time) const {
    return distance(form_.coarse(time), form_.fine(time)) < proportional;
  }

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    if (stop.stop_requested() || work_ + form_.work > budget_) return std::nullopt;
    work_ += form_.work;
    MotionState state = form_.fine(time);
    if (!state.momentum.allFinite() || !state.attitude.allFinite()) return std::nullopt;
    // Rounding of the reported numbers, and of every angle on the way.
    constexpr double reported = std::numeric_limits<long double>::epsilon();
    const double angle = form_.rate * std::abs(time);
    const double rounding = reported + form_.precision.unit * angle + 2 * form_.start * (1 + angle);
    error_ =
        std::max({error_, rounding, form_.precision.finer * distance(form_.coarse(time), state)});
    return Answer{std::move(state), error_};
  }

  std::string description() const override { return form_.description; }
  double work() const override { return work_; }
  double answer_work() const override { return form_.work; }
  std::optional<double> predicted_work(double, const std::stop_token&) override {
    return work_ + form_.work;
  }

 private:
  ClosedForm form_;
  double budget_, work_ = 0, error_ = 0;
};

template <class Scalar, class Derived>
auto rounded(const Eigen::MatrixBase<Derived>& A) {
  return A.template cast<Scalar>().eval();
}

using Start = SeriesStart<Quad>;

/// The precision in which the states of a closed form in Scalar are put into the scene's variables.
template <class Scalar>
using Shown = std::conditional_t<std::is_same_v<Scalar, Quad>, Quad, long double>;

template <class Scalar>
Presentation<Shown<Scalar>> presentation(const Start& start) {
  const Presentation<Quad>& as = start.presentation;
  return {as.right, as.complex, rounded<Shown<Scalar>>(as.diagonal),
          rounded<Shown<Scalar>>(as.axes)};
}

/// Returns the motion of Euler's top that starts at Q = I, multiplied by Q_0 from the left.
template <class Scalar, bool frame>
Solution top(const Start& start) {
  typename So3<Scalar, frame>::State x;
  x.setZero();
  if constexpr (frame) x(0) = 1;
  const Matrix<Quad> M = start.x.bottomRows(3);
  x.template tail<3>() = vee(rounded<Scalar>(M));
  const PrincipalMoments3<Quad> I(start.lambda);
  const PrincipalMoments3<Scalar> moments(rounded<Scalar>(I.moments),
                                          rounded<Scalar>(I.differences));
  using Wide = Shown<Scalar>;
  return
      [as = presentation<Scalar>(start), Q_0 = rounded<Wide>(start.x.topRows(start.x.rows() - 3)),
       motion = EulerTop<Scalar, frame>(moments, x)](double t) {
        const auto at = motion.at(Scalar(t));
        Matrix<Wide> now(frame ? 6 : 3, 3);
        if constexpr (frame)
          now.topRows(3) = Q_0 * rounded<Wide>(rotation_matrix<Scalar>(at.template head<4>()));
        now.bottomRows(3) = rounded<Wide>(hat(Vector3<Scalar>(at.template tail<3>())));
        return present(as, now, 3);
      };
}
template <class Scalar>
Solution top(const Start& start) {
  return start.x.rows() > 3 ? top<Scalar, true>(start) : top<Scalar, false>(start);
}

template <class Scalar>
Solution two_valued(const Start& start) {
  return [as = presentation<Scalar>(start), N = start.x.cols(),
          motion = TwoValuedBody<Scalar>(rounded<Scalar>(start.lambda), rounded<Scalar>(start.x))](
             double t) mutable {
    return present<Shown<Scalar>>(as, rounded<Shown<Scalar>>(motion.at(Scalar(t))), N);
  };
}

template <class Scalar>
Solution isotropic_geodesic(const Start& start) {
  return [as = presentation<Scalar>(start), n = start.x.rows() / 2,
          motion = IsotropicGeodesic<Scalar>(rounded<Scalar>(start.lambda),
                                             rounded<Scalar>(start.x))](double t) mutable {
    return present<Shown<Scalar>>(as, rounded<Shown<Scalar>>(motion.at(Scalar(t))), n);
  };
}

/// Units of work of a state in both precisions, as callgrind counts them: for Euler's top, and for
/// the eigenvectors of a complex n × n matrix with the products of `rows` × n matrices with them.
constexpr double top_in_quadruple = 1.4e6, top_in_extended = 1.6e4;
double eigenvectors_work(Eigen::Index n, Eigen::Index rows) {
  const auto d = static_cast<double>(n), r = static_cast<double>(rows);
  return 5e4 + 600 * d * d * d + 50 * r * d * d;
}

/// Returns ‖Ω‖_F, Ω_ij = M_ij/(λ_i + λ_j).
double body_rate(const Start& start) {
  const Eigen::Index N = start.x.cols();
  const auto M = start.x.bottomRows(N);
  double sum = 0;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      const auto Omega =
          static_cast<double>(M(i, j)) / static_cast<double>(start.lambda(i) + start.lambda(j));
      sum += 2 * Omega * Omega;
    }
  return std::sqrt(sum);
}

ClosedForm top_form(const Start& start, bool quadruple) {
  if (quadruple)
    return {top<Quad>(start), top<long double>(start),
            in_quadruple,     body_rate(start),
            top_in_quadruple, "Jacobi's closed form in quadruple precision"};
  return {
      top<long double>(start), top<double>(start), in_extended,
      body_rate(start),        top_in_extended,    "Jacobi's closed form in extended precision"};
}

/// Most units of work for eigenvectors, whose computation cannot be stopped: half a second.
constexpr double at_once = 2.5e9;

std::unique_ptr<ExactReference> reference(ClosedForm form, const ReferenceNeed& need, double time) {
  auto made = std::make_unique<ExactReference>(std::move(form), need.budget);
  return made->holds_at(time) ? std::move(made) : nullptr;
}

/// Whether a scene with this Λ may have a closed form. Tested first, because computing the start
/// takes products of matrices.
bool may_have_closed_form(const Eigen::VectorXd& lambda) {
  return lambda.size() == 3 || (lambda.size() > 1 && (TwoValuedBody<double>::has(lambda) ||
                                                      IsotropicGeodesic<double>::has(lambda)));
}

}  // namespace

std::unique_ptr<Reference> closed_form_of_body(const Start& start, const ReferenceNeed& need,
                                               double time, double allowed) {
  const Eigen::Index N = start.x.cols();
  const double work = N == 3 ? top_in_extended : eigenvectors_work(N, N);
  if (work > allowed) return nullptr;
  if (N == 3) {
    for (const bool quadruple : {need.quadruple, true})
      if (auto made = reference(top_form(start, quadruple), need, time)) return made;
    return nullptr;
  }
  if (!TwoValuedBody<double>::has(rounded<double>(start.lambda))) return nullptr;
  return reference(
      {two_valued<long double>(start), two_valued<double>(start), in_extended, body_rate(start),
       work, "closed form for Lambda of two values in extended precision"},
      need, time);
}

std::unique_ptr<Reference> closed_form_of_geodesic(const Start& start, const ReferenceNeed& need,
                                                   double time, double allowed) {
  const double work = eigenvectors_work(start.x.rows(), start.x.cols());
  const Eigen::VectorXd lambda = rounded<double>(start.lambda);
  if (work > allowed || !IsotropicGeodesic<double>::has(lambda)) return nullptr;
  const Eigen::Index rows = start.x.rows() / 2;
  const Matrix<Quad> Q = start.x.topRows(rows);
  const Matrix<Quad> defect = Q * Q.transpose() - Matrix<Quad>::Identity(rows, rows);
  const double S = start.x.bottomRows(rows).cast<double>().norm();
  return reference({isotropic_geodesic<long double>(start), isotropic_geodesic<double>(start),
                    in_extended, S / lambda(0), work,
                    "closed form for Lambda a multiple of the identity in extended precision",
                    defect.cast<double>().norm()},
                   need, time);
}

std::unique_ptr<Reference> make_exact_reference(const Scene& scene, const ReferenceNeed& need) {
  const Eigen::VectorXd& lambda = scene.inertia();
  const auto n = static_cast<double>(scene.Q().rows());
  const double least_work = 80 * n * n * static_cast<double>(lambda.size());  // work of the start
  // A closed form that exceeds the budget but is cheap to construct is constructed, to report its
  // price.
  const double allowed = std::min(at_once, std::max(need.budget, top_in_extended));
  if (!may_have_closed_form(lambda) || least_work > allowed) return nullptr;
  const MotionStart* motion = system_entry(scene.system())->motion;
  if (motion == nullptr) return nullptr;
  const Start start = motion->quadruple(scene);
  const auto closed_form = start.equations->closed_form;
  if (closed_form == nullptr) return nullptr;
  return closed_form(start, need, std::copysign(need.time, scene.step()), allowed);
}

}  // namespace stiefel
