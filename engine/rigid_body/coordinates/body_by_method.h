#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

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

/// Whether a scene is given by `body` and its method is the closed form.
bool is_exact_body(const Scene& scene);

/// Returns the simulation of a scene given by `body` with the method `exact`. It moves the body
/// with the caller's numbers; other methods start from Λ and M rounded to doubles.
std::unique_ptr<Simulation> exact_body(const Scene& scene);

}  // namespace stiefel
