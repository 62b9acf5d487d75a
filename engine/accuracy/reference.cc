#include "engine/accuracy/reference.h"

#include <algorithm>
#include <cmath>

#include "engine/accuracy/series_equations.h"
#include "engine/motion/system_entry.h"
#include "stiefel/simulation.h"

namespace stiefel {
namespace {

using Wide = Matrix<long double>;

const Field* field_of(const Simulation& now, std::string_view name) {
  const auto found = std::ranges::find(now.fields(), name, &Field::name);
  return found == now.fields().end() ? nullptr : &*found;
}

/// Returns the largest modulus of an element.
long double largest(const Wide& A, bool complex) {
  if (!complex) return A.cwiseAbs().maxCoeff();
  using EverySecondColumn = Eigen::Map<const Wide, 0, Eigen::OuterStride<>>;
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
    const Wide block = now.get(field->name).cast<long double>();
    const Eigen::Index size = state.momentum.size();
    state.momentum.conservativeResize(size + block.size(), 1);
    state.momentum.bottomRows(block.size()) = block.reshaped<Eigen::RowMajor>();
  }
}

}  // namespace

MotionState read_motion(const Scene& scene, const Simulation& now) {
  const auto get = [&](const char* name) -> Wide { return now.get(name).cast<long double>(); };
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

std::unique_ptr<Reference> make_taylor_reference(const Scene& scene, const ReferenceNeed& need) {
  const MotionStart* motion = system_entry(scene.system())->motion;
  return motion ? motion->equations->taylor(motion->extended(scene), need) : nullptr;
}

std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need) {
  if (auto closed_form = make_exact_reference(scene, need)) return closed_form;
  return make_taylor_reference(scene, need);
}

}  // namespace stiefel
