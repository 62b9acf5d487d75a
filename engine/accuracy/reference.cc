#include "engine/accuracy/reference.h"

#include <algorithm>
#include <cmath>

#include "engine/accuracy/series_equations.h"
#include "engine/motion/system_entry.h"
#include "stiefel/simulation.h"

namespace stiefel {
namespace {

using WideMatrix = Matrix<long double>;

const Field* field_of(const Simulation& now, std::string_view name) {
  const auto found = std::ranges::find(now.fields(), name, &Field::name);
  return found == now.fields().end() ? nullptr : &*found;
}

/// Returns the largest modulus of an element.
long double largest(const WideMatrix& A, bool complex) {
  if (!complex) return A.cwiseAbs().maxCoeff();
  using EverySecondColumn = Eigen::Map<const WideMatrix, 0, Eigen::OuterStride<>>;
  const Eigen::OuterStride<> two_columns(2 * A.rows());
  const EverySecondColumn real(A.data(), A.rows(), A.cols() / 2, two_columns),
      imaginary(A.data() + A.rows(), A.rows(), A.cols() / 2, two_columns);
  const auto modulus = [](long double x, long double y) { return std::hypot(x, y); };
  return real.binaryExpr(imaginary, modulus).maxCoeff();
}

const char* momentum_of(const Simulation& now) {
  for (const char* name : {"M", "P"})
    if (field_of(now, name) != nullptr) return name;
  return nullptr;
}

bool is_frame(const Field& field) { return field.name == "Q" || field.name == "q"; }

/// Sets the momentum of a system that has no block of that name from its other blocks.
void read_other_blocks(const Simulation& now, MotionState& state) {
  std::vector<const Field*> others;
  for (const Field& field : std::span(now.fields()).first(now.block_count()))
    if (!is_frame(field)) others.push_back(&field);
  if (others.size() == 1) {
    state.momentum = now.get(others.front()->name).cast<long double>();
    state.complex = state.complex || others.front()->complex;
    return;
  }
  for (const Field* field : others) {
    const WideMatrix block = now.get(field->name).cast<long double>();
    const Eigen::Index size = state.momentum.size();
    state.momentum.conservativeResize(size + block.size(), 1);
    state.momentum.bottomRows(block.size()) = block.reshaped<Eigen::RowMajor>();
  }
}

}  // namespace

MotionState read_motion(const Scene& scene, const Simulation& now) {
  const auto get = [&](const char* name) -> WideMatrix {
    return now.get(name).cast<long double>();
  };
  MotionState state;
  for (const char* name : {"Q", "q"})
    if (const Field* field = field_of(now, name)) {
      state.attitude = get(name);
      state.complex = field->complex;
    }
  if (field_of(now, "Qdot") != nullptr)
    state.momentum = get("Qdot") * scene.inertia().cast<long double>().asDiagonal();
  else if (const char* name = momentum_of(now))
    state.momentum = get(name);
  else
    read_other_blocks(now, state);
  return state;
}

MotionError error_of(const MotionState& state, const MotionState& exact) {
  const bool complex = exact.complex;
  MotionError error;
  if (state.attitude.size() > 0 && exact.attitude.size() > 0)
    error.attitude = static_cast<double>(largest(state.attitude - exact.attitude, complex));
  const long double size = largest(exact.momentum, complex);
  error.momentum = static_cast<double>(largest(state.momentum - exact.momentum, complex) /
                                       (size > 0 ? size : 1));
  return error;
}

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
  ExactReference(ComparedForm form, double budget) : form_(std::move(form)), budget_(budget) {}

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
    const double least = reported + form_.precision.unit * angle + 2 * form_.start * (1 + angle);
    error_ = std::max({error_, least, form_.precision.finer * distance(form_.coarse(time), state)});
    return Answer{std::move(state), error_};
  }

  std::string description() const override { return form_.description; }
  double work() const override { return work_; }
  double answer_work() const override { return form_.work; }
  double predicted_work(double, const std::stop_token&) override { return work_ + form_.work; }

 private:
  ComparedForm form_;
  double budget_, work_ = 0, error_ = 0;
};

/// Most units of work for eigenvectors, whose computation cannot be stopped: half a second.
constexpr double at_once = 2.5e9;

}  // namespace

double eigenvectors_work(Eigen::Index n, Eigen::Index rows) {
  const auto d = static_cast<double>(n), r = static_cast<double>(rows);
  return 5e4 + 600 * d * d * d + 50 * r * d * d;
}

std::unique_ptr<Reference> closed_form_reference(ComparedForm form, const ReferenceNeed& need,
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

std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need) {
  const MotionStart* motion = system_entry(scene.system())->motion;
  return motion ? motion->equations->taylor(motion->extended(scene), need) : nullptr;
}

std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need) {
  if (auto closed_form = make_exact_reference(scene, need)) return closed_form;
  return make_taylor_reference(scene, need);
}

}  // namespace stiefel
