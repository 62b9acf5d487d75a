#pragma once

#include "engine/methods/adaptive.h"
#include "engine/methods/crouch_grossman3.h"
#include "engine/methods/exact.h"
#include "engine/methods/gauss4.h"
#include "engine/methods/implicit_midpoint.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/rk4.h"
#include "engine/methods/splitting.h"
#include "engine/methods/variational.h"

namespace stiefel {

template <class... M>
struct TypeList {};

/// visit(static_cast<T*>(nullptr)) for every T in the list.
template <class... T, class Visit>
void for_each_type(TypeList<T...>, Visit&& visit) {
  (visit(static_cast<T*>(nullptr)), ...);
}

/// The catalogue of methods. A new one is a file in engine/methods and a line here.
using Methods = TypeList<     //
    Variational,              //
    PreprocessedVariational,  //
    Exact,                    //
    Splitting,                //
    MuntheKaas4,              //
    CrouchGrossman3,          //
    ImplicitMidpoint,         //
    Gauss4,                   //
    Rk4,                      //
    Adaptive>;

}  // namespace stiefel
