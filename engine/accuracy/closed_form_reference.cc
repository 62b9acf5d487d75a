#include "engine/accuracy/closed_form_reference.h"

#include <algorithm>
#include <cmath>

#include "engine/motion/system_entry.h"

namespace stiefel {
namespace {

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
  double predicted_work(double, const std::stop_token&) override { return work_ + form_.work; }

 private:
  ClosedForm form_;
  double budget_, work_ = 0, error_ = 0;
};

/// Most units of work for eigenvectors, whose computation cannot be stopped: half a second.
constexpr double at_once = 2.5e9;

}  // namespace

double eigenvectors_work(Eigen::Index n, Eigen::Index rows) {
  const auto d = static_cast<double>(n), r = static_cast<double>(rows);
  return 5e4 + 600 * d * d * d + 50 * r * d * d;
}

std::unique_ptr<Reference> closed_form_reference(ClosedForm form, const ReferenceNeed& need,
                                                 double time) {
  auto made = std::make_unique<ExactReference>(std::move(form), need.budget);
  return made->holds_at(time) ? std::move(made) : nullptr;
}

std::unique_ptr<Reference> make_exact_reference(const Scene& scene, const ReferenceNeed& need) {
  const MotionStart* motion = system_entry(scene.system())->motion;
  if (motion == nullptr || motion->equations->closed_form == nullptr) return nullptr;
  const Eigen::VectorXd& lambda = scene.inertia();
  const auto n = static_cast<double>(scene.Q().rows());
  const double least_work = 80 * n * n * static_cast<double>(lambda.size());  // work of the start
  // A closed form that exceeds the budget but is cheap to construct is constructed, to report its
  // price.
  const double allowed = std::min(at_once, std::max(need.budget, top_in_extended));
  if (!motion->equations->has_closed_form(lambda) || least_work > allowed) return nullptr;
  return motion->equations->closed_form(motion->quadruple(scene), need,
                                        std::copysign(need.time, scene.step()), allowed);
}

}  // namespace stiefel
