#include "engine/simulation/stepping/matrix_simulation.h"

#include "engine/simulation/stepping/make_map.h"
#include "engine/simulation/stepping/methods.h"

namespace stiefel {
namespace {

template <class Scalar>
using Offered = std::conditional_t<std::is_same_v<Scalar, float>, MethodsInFloat, Methods>;

/// Returns the simulation by the scene's method if `fits` is true for that method; else null.
template <class Scalar, class System, class Fits>
std::unique_ptr<Simulation> by_name(const Scene& scene, const System& system,
                                    const MatrixObservables<Scalar>& observables, double cost,
                                    Fits fits) {
  std::unique_ptr<Simulation> made;
  const auto attempt = [&]<class Method>(Method* method) {
    if constexpr (decltype(fits(method))::value)
      if (scene.method() == Method::traits.name)
        made = make_map<Method>(scene, system, observables, cost);
  };
  for_each_type(Offered<Scalar>{}, attempt);
  return made;
}

}  // namespace

template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost) {
  return by_name(scene, system, observables, cost, []<class Method>(Method*) {
    return std::bool_constant<by_field_alone<Method, MatrixSystem<Scalar>>>();
  });
}

template <class Scalar>
std::unique_ptr<Simulation> simulate_matrices(const Scene& scene,
                                              const MatrixLieSystem<Scalar>& system,
                                              const MatrixObservables<Scalar>& observables,
                                              double cost) {
  return by_name(scene, system, observables, cost, []<class Method>(Method*) {
    return std::bool_constant < by_action_alone<Method, MatrixLieSystem<Scalar>> &&
               !by_field_alone < Method,
           MatrixLieSystem < Scalar >>> ();
  });
}

template std::unique_ptr<Simulation> simulate_matrices(const Scene&, const MatrixSystem<double>&,
                                                       const MatrixObservables<double>&, double);
template std::unique_ptr<Simulation> simulate_matrices(const Scene&, const MatrixLieSystem<double>&,
                                                       const MatrixObservables<double>&, double);
template std::unique_ptr<Simulation> simulate_matrices(const Scene&, const MatrixSystem<float>&,
                                                       const MatrixObservables<float>&, double);

}  // namespace stiefel
