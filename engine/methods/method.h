#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "engine/methods/concepts.h"
#include "engine/methods/matrix_system.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/pack.h"
#include "stiefel/conservation.h"

namespace stiefel {

/// The names of methods that others ask for: a change of a method then compiles its steps alone.
namespace method_name {
inline constexpr const char *exact = "exact", *preprocessed = "preprocessed_variational",
                            *rk4 = "rk4", *variational = "variational";
}

/// What a system says of itself to a method, as values. A general method
/// decides by these whether it applies to a system, and what it does to an invariant, without being
/// compiled for that system. A null pointer means that the system says nothing.
struct SystemTraits {
  using Property = bool (*)(std::string_view invariant);

  bool lie_group = false;  ///< the system is a LieSystem
  bool projects = false;   ///< the system has `project`, onto the manifold of its states
  /// Whether the invariant is quadratic, or a function of quadratic invariants.
  Property quadratic = nullptr;
  /// Whether the invariant is constant on the orbits of the group. Every LieSystem declares it.
  Property conserved_on_orbits = nullptr;
  /// Whether the error of the invariant has no trend even by a method that keeps nothing.
  Property without_trend = nullptr;
  /// What every method does to the invariant; nullopt: the method decides.
  std::optional<Conservation> (*conservation)(std::string_view invariant) = nullptr;
};

/// The traits of the system S.
template <class S>
inline constexpr SystemTraits system_traits = [] {
  SystemTraits traits;
  traits.projects = requires(S & system, typename S::State & x) { system.project(x); };
  if constexpr (LieSystem<S>) {
    traits.lie_group = true;
    traits.conserved_on_orbits = [](std::string_view v) { return S::conserved_on_orbits(v); };
  }
  if constexpr (requires(std::string_view v) { S::quadratic(v); })
    traits.quadratic = [](std::string_view v) { return S::quadratic(v); };
  if constexpr (requires(std::string_view v) { S::without_trend(v); })
    traits.without_trend = [](std::string_view v) { return S::without_trend(v); };
  if constexpr (requires(std::string_view v) { S::conservation(v); })
    traits.conservation = [](std::string_view v) { return S::conservation(v); };
  return traits;
}();

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

/// A Method turns a System into a Map, by `map_of(Method, system, h, MethodOptions)`: a general
/// method by the function below, another by overloads that stand in the wings of the systems for
/// which it is made. `conservation` says what it does to an invariant of a system.
template <class M>
concept Method = requires(const SystemTraits& system, std::string_view v) {
  { M::traits } -> std::convertible_to<MethodTraits>;
  { M::conservation(system, v) } -> std::convertible_to<Conservation>;
};

/// A method that applies to every system that says of itself what the method needs, and has a
/// `Map<S>(system, h, MethodOptions)` for each.
template <class M>
concept GeneralMethod = Method<M> && requires(const SystemTraits& system) {
  { M::applies_to(system) } -> std::convertible_to<bool>;
};

/// What a general method is compiled for: all systems with matrices as states are one.
template <class S>
struct CompiledFor {
  using type = S;
};
template <HasMatrixStates S>
struct CompiledFor<S> {
  using type = MatrixSystem<typename S::Scalar>;
};

/// Returns the map of a step h of a system to which the method applies.
template <GeneralMethod M, System S>
requires(M::applies_to(system_traits<S>))
    typename M::template Map<typename CompiledFor<S>::type> map_of(M, const S& system,
                                                                   typename S::Scalar h,
                                                                   const MethodOptions& options) {
  return {system, h, options};
}

/// The map of the method for the system S.
template <class M, class S>
using MapOf = decltype(map_of(M(), std::declval<const S&>(), typename S::Scalar(),
                              std::declval<const MethodOptions&>()));

/// Whether the method applies to the system S.
template <class M, class S>
concept applies = requires {
  typename MapOf<M, S>;
};

/// What a method says of S, where it differs from what it says of all systems: what it does to an
/// invariant, and for which Λ it has a map. A specialisation stands beside map_of.
struct Declared {
  Conservation (*conservation)(std::string_view invariant) = nullptr;
  std::string_view where = {};
  bool (*takes)(const Eigen::VectorXd& lambda) = nullptr;
};
template <class M, class S>
inline constexpr Declared declared = {};

/// Base class of methods on Lie groups.
struct LieMethod {
  static constexpr bool applies_to(const SystemTraits& system) { return system.lie_group; }
  static constexpr Conservation conservation(const SystemTraits& system,
                                             std::string_view invariant) {
    return system.conserved_on_orbits(invariant) ? Conservation::exact : Conservation::drifts;
  }
};

template <class... T>
struct TypeList {};

/// Calls visit(static_cast<T*>(nullptr)) for every T in the list.
template <class... T, class Visit>
void for_each_type(TypeList<T...>, Visit&& visit) {
  (visit(static_cast<T*>(nullptr)), ...);
}

/// The memory of an iteration that does not use the solutions of earlier steps.
struct NoMemory {
  template <class Visitor>
  void each(Visitor&&) {}
};

/// The state of a map. Its next step depends on the system's state x and, with a memory, on earlier
/// solutions.
template <class Point, class Memory>
struct StateWithMemory {
  Accumulator<Point> x;
  [[no_unique_address]] Memory memory = {};

  template <class Visitor>
  void each(Visitor&& visit) {
    x.each(visit);
    memory.each(visit);
  }
};
template <class Point>
using PlainState = StateWithMemory<Point, NoMemory>;

/// Base class of explicit methods: a map x ← x + Δ(x), defined by its displacement Δ for every h. A
/// step always ends with `reached`; whoever iterates the map tests whether the state is finite.
template <class Derived, class S>
class ExplicitMap {
 public:
  using Point = typename S::State;
  using State = PlainState<Point>;

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
