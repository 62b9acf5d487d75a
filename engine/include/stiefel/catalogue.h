#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "stiefel/conservation.h"

namespace stiefel {

std::string_view to_string(Conservation conservation);

/// What a method declares about one invariant of one system.
struct Preservation {
  std::string_view invariant;
  Conservation conservation;
};

struct MethodInfo {
  std::string_view name;
  std::string_view summary;
  std::string_view source;
  std::string_view file;
  std::vector<int> orders;
  int default_order;
  bool reversible;
  double default_tolerance;  ///< 0 for methods that take steps of a fixed size
};

struct BlockInfo {
  std::string_view name;
  std::string_view shape;
  bool required;
  std::string_view description;
};

struct FieldInfo {
  std::string_view name;
  std::string_view shape;
  std::string_view description;
};

struct InvariantInfo {
  std::string_view name;
  std::string_view formula;
  std::string_view source;
};

/// A two-form on the states of a system. `blocks` names the two blocks of its tangent vectors.
struct FormInfo {
  std::string_view name;
  std::array<std::string_view, 2> blocks;
  std::string_view formula;
  std::string_view source;
};

/// What a method offers on one system. The name is empty for a discrete system, which takes no
/// method.
struct MethodOnSystem {
  std::string_view method;
  std::vector<Preservation> preserves;
  std::string_view where = {};  ///< "N = 3"; empty: in every scene
  /// Whether the method accepts a scene with this Λ; null: it accepts every one.
  bool (*takes)(const Eigen::VectorXd& lambda) = nullptr;
  bool in_float = false;  ///< offered in single precision too
};

struct SystemInfo {
  std::string_view name;
  std::string_view summary;
  std::string_view equations;
  std::string_view source;
  std::string_view file;
  bool discrete;
  std::vector<BlockInfo> blocks;
  std::vector<FieldInfo> fields;
  std::vector<InvariantInfo> invariants;
  std::vector<MethodOnSystem> methods;
  std::vector<FormInfo> forms;
};

/// Describes all systems and methods, as data. Built once.
struct Catalogue {
  std::vector<SystemInfo> systems;
  std::vector<MethodInfo> methods;

  /// Return null if there is none of that name.
  const SystemInfo* system(std::string_view name) const;
  const MethodInfo* method(std::string_view name) const;
};

const Catalogue& catalogue();

}  // namespace stiefel
