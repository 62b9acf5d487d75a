#pragma once

#include <string>
#include <vector>

#include "engine/simulation/scene/scene.h"

namespace stiefel {

/// What is doubtful about a scene that is accepted, one sentence each; mostly none.
///
/// The motion is defined wherever λ_i + λ_j > 0, but λ_i is a second moment of mass: below 0 it
/// belongs to no rigid body. In three dimensions λ_3 < 0 is I_1 + I_2 < I_3. Roundings of the
/// moments of a flat body, where λ_3 = 0, are none.
std::vector<std::string> warnings(const Scene& scene);

}  // namespace stiefel
