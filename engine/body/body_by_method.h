#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine/body/exact/top_in_time.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {

/// The rigid body moved by one method, in the coordinates that the method offers.
struct BodyByMethod {
  using Make = std::unique_ptr<Simulation> (*)(const Scene&);

  std::string_view method;
  MethodOnSystem (*declared)(const SystemInfo&);
  Make make;
};

/// Returns the methods that move rigid bodies, in the order of the catalogue.
const std::vector<BodyByMethod>& bodies_by_methods();

/// Returns the simulation of a rigid body by the scene's method; of the discrete body, whose map is
/// that of `variational` of order 2.
std::unique_ptr<Simulation> make_body_simulation(const Scene& scene);

/// Whether a scene of a rigid body has the method `exact` and three dimensions.
bool is_exact_body(const Scene& scene);

/// Returns the simulation of such a scene. A body given by `body` moves with the caller's numbers;
/// other methods start from Λ and M rounded to doubles.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

/// Returns the motion of such a body from (q; m), or from m where it has no frame.
TopInTime top_in_time(const Scene& scene, std::span<const double> state);

}  // namespace stiefel
