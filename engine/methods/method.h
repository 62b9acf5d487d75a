#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "engine/methods/concepts.h"
#include "engine/methods/system_traits.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/lanes.h"
#include "stiefel/conservation.h"

namespace stiefel {

/// Selects how a method moves rigid bodies of three and four dimensions in the lanes of vector
/// registers.
enum class Packing {
  none,              ///< each body alone
  vector_field,      ///< by the vector field, with the λ of each body
  stages,            ///< by the Moser–Veselov stages of each body
  modified_inertia,  ///< by one Moser–Veselov stage with each body's modified moments
};

/// What a method declares, as data. Tests, Diagnose and the documentation read it.
struct MethodTraits {
  const char* name;
  const char* summary;
  const char* source;
  const char* file;
  std::array<int, 7> orders;  ///< ascending, padded with 0; all 0 for a closed form
  int default_order;
  bool reversible;               ///< a step by −h undoes a step by h
  bool iterates = false;         ///< a step solves an equation by iteration: its work varies
  double default_tolerance = 0;  ///< 0 for methods that take steps of a fixed size
  bool in_float = false;         ///< moves bodies in three dimensions in single precision
  bool momentum_alone = false;   ///< where the scene has no Q, moves M alone in coordinates
  bool in_so4 = false;           ///< moves bodies of four dimensions in the coordinates of So4
  Packing packing = Packing::none;
};

/// What a scene chooses of a method.
struct MethodOptions {
  int order;
  Arithmetic arithmetic;
  double tolerance;  ///< 0: the method's default

  MethodOptions(int o = 0, Arithmetic a = Arithmetic::compensated, double t = 0)
      : order(o), arithmetic(a), tolerance(t) {}
};

/// A Method turns a System into a Map: `Method::traits` and `Method::Map<S>(system, h,
/// MethodOptions)`, with a general rule, with maps for single systems, or with both:
///
///     general   applies_to(SystemTraits), conservation(SystemTraits, invariant)
///     special   has_map_for<S>, conservation<S>(invariant); S has its file in its wing
template <class M>
concept Method = requires {
  { M::traits } -> std::convertible_to<MethodTraits>;
};

/// A method that applies to every system that says of itself what the method needs.
template <class M>
concept GeneralMethod = Method<M> && requires(const SystemTraits& system, std::string_view v) {
  { M::applies_to(system) } -> std::convertible_to<bool>;
  { M::conservation(system, v) } -> std::convertible_to<Conservation>;
};

/// Whether the method has a map made for the system S.
template <class M, class S>
constexpr bool has_map_for = [] {
  if constexpr (requires { M::template has_map_for<S>; })
    return M::template has_map_for<S>;
  else
    return false;
}();

/// Whether the method applies to the system S.
template <class M, class S>
constexpr bool applies = [] {
  if constexpr (has_map_for<M, S>)
    return true;
  else if constexpr (GeneralMethod<M>)
    return System<S> && M::applies_to(system_traits<S>);
  else
    return false;
}();

/// Returns what the method does to an invariant of S: what S declares of every method if it does,
/// else what the method declares.
template <class M, class S>
constexpr Conservation conservation_by(std::string_view invariant) {
  if constexpr (requires { S::conservation(invariant); })
    if (const auto conservation = S::conservation(invariant)) return *conservation;
  if constexpr (has_map_for<M, S>)
    return M::template conservation<S>(invariant);
  else
    return M::conservation(system_traits<S>, invariant);
}

template <class... T>
struct TypeList {};

/// Calls visit(static_cast<T*>(nullptr)) for every T in the list.
template <class... T, class Visit>
void for_each_type(TypeList<T...>, Visit&& visit) {
  (visit(static_cast<T*>(nullptr)), ...);
}

/// The methods with a map made for S, a TypeList. A specialisation stands in the wing of S.
template <class S>
struct SpecialMethods {
  using type = TypeList<>;
};

/// The state of a map whose next step depends only on the system's state.
template <class S>
struct PlainState {
  Accumulator<typename S::State> x;

  template <class Visitor>
  void each(Visitor&& visit) {
    x.each(visit);
  }
};

/// Base class of explicit methods: a map x ← x + Δ(x), defined by its displacement Δ for every h. A
/// step always ends with `reached`; whoever iterates the map tests whether the state is finite.
template <class Derived, class S>
class ExplicitMap {
 public:
  using Point = typename S::State;
  using State = PlainState<S>;

  ExplicitMap(S system, typename S::Scalar h, const MethodOptions& options)
      : system_(std::move(system)), h_(h), arithmetic_(options.arithmetic) {}

  State start(const Point& x) {
    dx_ = x;
    return State{Accumulator<Point>(x, arithmetic_)};
  }

  RunStatus step(State& state) {
    static_cast<Derived*>(this)->displacement(state.x.value, dx_);
    state.x.add(dx_);
    return {};
  }

  /// For packs: makes the step in the lanes where the products of any two numbers stay finite and
  /// returns them. The states in the other lanes become undefined.
  [[gnu::always_inline]] Mask<typename S::Scalar> step_where_easy(State& state) {
    using Scalar = typename S::Scalar;
    static_cast<Derived*>(this)->inlined_displacement(state.x.value, dx_);
    state.x.add(dx_);
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dx_.size(); ++i) sum += state.x.value(i) * state.x.value(i);
    return Scalar(0) * sum <= Scalar(0);
  }

  std::optional<double> largest_step(const State&, double) const { return std::nullopt; }

 protected:
  S system_;
  typename S::Scalar h_;

 private:
  Arithmetic arithmetic_;
  Point dx_;
};

}  // namespace stiefel
