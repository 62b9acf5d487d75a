#pragma once

#include "engine/frames/passes/rattle_stiefel.h"
#include "engine/methods/exact.h"
#include "engine/methods/support/composition.h"
#include "engine/rigid_body/moser_veselov/symmetric_moser_veselov.h"
#include "engine/stepping/make_simulation.h"

namespace stiefel {

// Simulations of maps that several systems share, compiled once, in shared_maps.cc.
extern template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<ClosedFormMap<Matrix<double>>>&, const SharedObservables&,
    bool);
extern template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<Composition<RattleStiefel<double>>>&, const SharedObservables&,
    bool);
extern template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<Composition<SymmetricMoserVeselov<double>>>&,
    const SharedObservables&, bool);

}  // namespace stiefel
