#pragma once

#include <type_traits>

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

/// Calls visit(static_cast<T*>(nullptr)) for every T in the list.
template <class... T, class Visit>
void for_each_type(TypeList<T...>, Visit&& visit) {
  (visit(static_cast<T*>(nullptr)), ...);
}

template <class... Lists>
struct Joined {
  using type = TypeList<>;
};
template <class... A>
struct Joined<TypeList<A...>> {
  using type = TypeList<A...>;
};
template <class... A, class... B, class... Rest>
struct Joined<TypeList<A...>, TypeList<B...>, Rest...> : Joined<TypeList<A..., B...>, Rest...> {};

template <bool MethodTraits::*declared, class List>
struct Declaring;
template <bool MethodTraits::*declared, class... M>
struct Declaring<declared, TypeList<M...>>
    : Joined<std::conditional_t<M::traits.*declared, TypeList<M>, TypeList<>>...> {};

/// The catalogue of methods. A new method is a file in engine/methods and a line here.
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

/// The methods whose traits declare the property `declared`, such as &MethodTraits::in_float.
template <bool MethodTraits::*declared>
using MethodsThat = typename Declaring<declared, Methods>::type;

/// The methods of the systems that are offered in single precision. The state is rounded to 24 bits
/// at the start, and all computations on it use 24 bits, including the carries of compensated
/// arithmetic.
using MethodsInFloat = MethodsThat<&MethodTraits::in_float>;

}  // namespace stiefel
