#pragma once

#include "engine/simulation/stepping/methods.h"
#include "engine/simulation/stepping/stacked_observables.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {

std::unique_ptr<Simulation> rigid_body_in_float(const Scene& scene);
std::unique_ptr<Simulation> stiefel_in_float(const Scene& scene,
                                             const StackedObservables& observables);

/// Marks the methods of a system that are offered in single precision in the catalogue.
inline void offer_in_float(SystemInfo& info) {
  for_each_type(MethodsInFloat{}, [&]<class Method>(Method*) {
    for (MethodOnSystem& on : info.methods)
      if (on.method == Method::traits.name) on.in_float = true;
  });
}

/// States in single precision, for StoredAs.
template <class Wide_>
struct SinglePrecision {
  using Wide = Wide_;
  using Point = Eigen::Matrix<float, Wide::RowsAtCompileTime, Wide::ColsAtCompileTime>;
  static Point to_stored(const Wide& x) { return rounded_to<float>(x); }
  static Wide to_wide(const Point& x) { return x.template cast<double>(); }
};

}  // namespace stiefel
