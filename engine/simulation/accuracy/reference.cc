#include "engine/simulation/accuracy/reference.h"

#include <algorithm>
#include <cmath>

#include "stiefel/simulation.h"

namespace stiefel {
namespace {

using Wide = Matrix<long double>;

const Field* field_of(const Simulation& now, std::string_view name) {
  const auto found = std::ranges::find(now.fields(), name, &Field::name);
  return found == now.fields().end() ? nullptr : &*found;
}

/// The largest modulus of an element.
long double largest(const Wide& A, bool complex) {
  if (!complex) return A.cwiseAbs().maxCoeff();
  const auto real = Eigen::seq(0, A.cols() - 2, 2), imaginary = Eigen::seq(1, A.cols() - 1, 2);
  const auto modulus = [](long double x, long double y) { return std::hypot(x, y); };
  return A(Eigen::all, real).binaryExpr(A(Eigen::all, imaginary), modulus).maxCoeff();
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
  else
    state.momentum = get(field_of(now, "M") != nullptr ? "M" : "P");
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

std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need) {
  if (auto closed_form = make_exact_reference(scene, need)) return closed_form;
  return make_taylor_reference(scene, need);
}

}  // namespace stiefel
