#pragma once

#include <optional>
#include <string>

#include "engine/simulation/run/simulation.h"

namespace stiefel {

/// The rate (`Simulation::rate`) at the last good state, where `last` is; of an ensemble that of
/// the member that ended the run.
double rate_at(const RunStatus& status, const Simulation& last);

/// One sentence for people, empty when reached: with what takes the scene where its method does not
/// and, where a step left the domain of a body in three dimensions, by how many degrees it turns
/// the body at that rate.
std::string to_sentence(const RunStatus& status, const Scene& scene, double rate);

}  // namespace stiefel
