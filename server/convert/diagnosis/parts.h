#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/convert/convert.h"
#include "server/convert/diagnosis/task.h"
#include "stiefel/diagnosis.h"

namespace stiefel::server {

/// A two-form and the tangent vectors on which it is evaluated.
struct FormTask {
  std::string name;
  TangentVector first, second;
};
/// The two functions of a Dirac bracket.
struct BracketTask {
  PairFactors first, second;
};

/// Returns the path of an element of a list: "forms[2]".
template <class Index>
std::string indexed(const char* field, Index i) {
  return std::string(field) + "[" + std::to_string(i) + "]";
}

/// A checked request.
struct DiagnoseTask::Parts {
  std::vector<std::string> invariants;
  std::vector<FormTask> forms;
  std::vector<BracketTask> brackets;
  std::optional<v1::SymplecticTest> symplectic;
  bool large = false;  ///< the scene is so large that each invariant is work
  v1::ErrorEstimation estimate_error = v1::ERROR_ESTIMATION_UNSPECIFIED;
  std::size_t max_invariants = 0;

  bool estimates_error() const { return estimate_error != v1::ERROR_ESTIMATION_UNSPECIFIED; }
};

/// The most work of an error estimate, in instructions: about ten seconds.
inline constexpr double most_estimate_work = 5e10;
/// An estimate of at most so much work, about ten milliseconds, is cheap whatever the run takes.
inline constexpr double small_estimate_work = 5e7;

}  // namespace stiefel::server
