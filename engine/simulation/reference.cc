#include "engine/simulation/reference.h"

#include <algorithm>

#include "engine/simulation/simulation.h"

namespace stiefel {
namespace {

using Wide = Matrix<long double>;

bool has_field(const Simulation& now, std::string_view name) {
  return std::ranges::any_of(now.fields(), [&](const Field& f) { return f.name == name; });
}

long double largest(const Wide& A) { return A.cwiseAbs().maxCoeff(); }

}  // namespace

MotionState read_motion(const Scene& scene, const Simulation& now) {
  const auto get = [&](const char* name) -> Wide { return now.get(name).cast<long double>(); };
  MotionState state;
  for (const char* name : {"Q", "q"})
    if (has_field(now, name)) state.attitude = get(name);
  if (has_field(now, "Qdot"))
    state.momentum = get("Qdot") * scene.inertia().cast<long double>().asDiagonal();
  else
    state.momentum = get(has_field(now, "M") ? "M" : "P");
  return state;
}

MotionError error_of(const MotionState& state, const MotionState& exact) {
  MotionError error;
  if (state.attitude.size() > 0 && exact.attitude.size() > 0)
    error.attitude = static_cast<double>(largest(state.attitude - exact.attitude));
  const long double size =
      std::max(largest(exact.momentum), std::numeric_limits<long double>::min());
  error.momentum = static_cast<double>(largest(state.momentum - exact.momentum) / size);
  return error;
}

std::unique_ptr<Reference> make_reference(const Scene& scene, const ReferenceNeed& need) {
  if (auto closed_form = make_exact_reference(scene, need)) return closed_form;
  if (auto series = make_taylor_reference(scene, need)) return series;
  return make_refined_reference(scene, need);
}

}  // namespace stiefel
