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
  Make in_double;
  Make in_float = {};  ///< null: MethodTraits::in_float is false
  Make in_so4 = {};    ///< N = 4, in both precisions; null: MethodTraits::in_so4 is false
};

/// Returns the methods that move rigid bodies, in the order of the catalogue.
const std::vector<BodyByMethod>& bodies_by_methods();

/// Returns the simulation of a rigid body by the scene's method.
std::unique_ptr<Simulation> make_body_simulation(const Scene& scene);

/// Returns the simulation of a rigid body by Method in single precision, and of one with N = 4 in
/// the coordinates of So4. Each method that offers it has a definition in a file of its own.
template <class Method>
std::unique_ptr<Simulation> body_in_float(const Scene& scene);
template <class Method>
std::unique_ptr<Simulation> body_in_so4(const Scene& scene);

}  // namespace stiefel
