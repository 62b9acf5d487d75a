#include "engine/body/taylor_parametric_rigid_body.h"

#include "engine/accuracy/taylor_reference.h"

namespace stiefel {

template class TaylorParametricRigidBody<long double>;
template class TaylorMotion<TaylorParametricRigidBody<long double>>;

constinit const SeriesEquations parametric_equations = {
    [](const SeriesStart<long double>& start, const ReferenceNeed& need) {
      const auto make = [&](int order) {
        return TaylorParametricRigidBody<long double>(start.lambda, start.mu, order);
      };
      return taylor_reference(make, start, need);
    }};

}  // namespace stiefel
