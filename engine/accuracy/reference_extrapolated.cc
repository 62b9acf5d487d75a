// A reference that uses only the vector field of a system.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "engine/accuracy/extrapolated_motion.h"
#include "engine/accuracy/reference.h"
#include "engine/catalogue/system_entry.h"
#include "engine/catalogue/vector_field.h"
#include "stiefel/simulation.h"

namespace stiefel {
namespace {

using Wide = Matrix<long double>;
using Motion = ExtrapolatedMotion<long double>;

constexpr int fine_columns = 8, coarse_columns = 6;
constexpr double fine_tolerance = 1e-17, coarse_tolerance = 1e-15;

/// Returns the units of work of one evaluation and of its share in the extrapolation: four
/// instructions for each operation of the field, and 80 for each number of the state.
double evaluation_work(const VectorField& system) {
  constexpr double instructions_of_operation = 4, instructions_of_number = 80;
  const auto numbers = static_cast<double>(system.start.size());
  const auto four_products = 8 * numbers * static_cast<double>(system.start.cols());
  const double operations = system.operations > 0 ? system.operations : four_products;
  return instructions_of_operation * operations + instructions_of_number * numbers;
}

/// Two solutions, of orders 16 and 12 and with tolerances that differ by a factor of 100. Their
/// distance is the error estimate, which exceeds the error of the better one.
class ExtrapolatedReference final : public Reference {
 public:
  ExtrapolatedReference(const VectorField& system, Eigen::Index rows, Eigen::Index cols,
                        double first, double budget)
      : frame_rows_(system.frame_rows),
        rows_(rows),
        cols_(cols),
        budget_(budget),
        evaluation_(evaluation_work(system)),
        fine_(system.field, system.start, frame_rows_, fine_columns, fine_tolerance, first),
        coarse_(system.field, system.start, frame_rows_, coarse_columns, coarse_tolerance, first) {}

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    // Begins no stride that exceeds the budget.
    const auto before = [&](int columns) {
      return [&, columns] { return stop.stop_requested() || work() + stride(columns) > budget_; };
    };
    if (!fine_.go_to(time, before(fine_columns)) || !coarse_.go_to(time, before(coarse_columns)))
      return std::nullopt;
    MotionState state = present(fine_.state());
    constexpr double unit = std::numeric_limits<long double>::epsilon();
    error_ = std::max({error_, fine_columns * unit * size(state),
                       error_of(present(coarse_.state()), state).largest()});
    return Answer{std::move(state), error_};
  }

  std::string description() const override {
    return "extrapolation of order " + std::to_string(2 * fine_columns) + " in extended precision";
  }
  double work() const override {
    return evaluation_ * static_cast<double>(fine_.evaluations() + coarse_.evaluations());
  }
  /// Both solutions end a stride at every answer.
  double answer_work() const override { return stride(fine_columns) + stride(coarse_columns); }
  /// Two strides, if they exceed the budget.
  std::optional<double> predicted_work(double time, const std::stop_token&) override {
    const double least = work() + stride(fine_columns) + stride(coarse_columns);
    return time != 0 && least > budget_ ? std::optional(least) : std::nullopt;
  }

 private:
  double stride(int columns) const {
    return evaluation_ * static_cast<double>(Motion::evaluations_of_stride(columns));
  }
  MotionState present(const Wide& x) const {
    const Wide momentum = x.bottomRows(x.rows() - frame_rows_);
    return {x.topRows(frame_rows_), momentum.reshaped<Eigen::RowMajor>(rows_, cols_)};
  }
  /// Returns the scale of the attitude's error: its largest entry, at least 1.
  static double size(const MotionState& state) {
    if (state.attitude.size() == 0) return 1;
    return std::max(1.0, static_cast<double>(state.attitude.cwiseAbs().maxCoeff()));
  }

  Eigen::Index frame_rows_, rows_, cols_;
  double budget_, evaluation_;
  Motion fine_, coarse_;
  double error_ = 0;
};

}  // namespace

std::unique_ptr<Reference> make_extrapolated_reference(const Scene& scene,
                                                       const ReferenceNeed& need) {
  const auto make = system_entry(scene.system())->vector_field;
  if (make == nullptr) return nullptr;
  const VectorField system = make(scene);
  const MotionState reported = read_motion(scene, *make_simulation(scene));
  const Eigen::Index rows = system.start.rows() - system.frame_rows;
  if (rows * system.start.cols() != reported.momentum.size())
    throw std::logic_error("the vector field of " + scene.system() +
                           " moves other blocks than its scenes report");
  return std::make_unique<ExtrapolatedReference>(system, reported.momentum.rows(),
                                                 reported.momentum.cols(), std::abs(scene.step()),
                                                 need.budget);
}

}  // namespace stiefel
