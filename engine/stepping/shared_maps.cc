#include "engine/stepping/shared_maps.h"

namespace stiefel {

template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<ClosedFormMap<Matrix<double>>>&, const SharedObservables&,
    bool);
template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<Composition<RattleStiefel<double>>>&, const SharedObservables&,
    bool);
template std::unique_ptr<Simulation> simulation_of(
    const Scene&, const MapOfLength<Composition<SymmetricMoserVeselov<double>>>&,
    const SharedObservables&, bool);

}  // namespace stiefel
