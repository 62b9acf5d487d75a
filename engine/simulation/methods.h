#pragma once

#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/rk4.h"
#include "engine/methods/variational.h"

namespace stiefel {

template <class... M>
struct TypeList {};

/// The catalogue of methods. A new one is a file in engine/methods and a line here.
using Methods = TypeList<  //
    Variational,           //
    MuntheKaas4,           //
    Rk4>;

}  // namespace stiefel
