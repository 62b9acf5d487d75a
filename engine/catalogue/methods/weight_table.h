#pragma once

#include <initializer_list>
#include <span>
#include <string_view>

namespace stiefel {

/// The instructions of a step at h‖Ω‖ = 0.1 in one size.
struct Counted {
  double n, N, instructions;
};

/// The number of instructions at h‖Ω‖ divided by that at 0.1, for dimension N and larger ones.
struct AtRate {
  double N, h_omega, factor;
};

/// An entry of step_weights.inc, which tests/bench/weights.py writes. The method of a discrete
/// system is "-"; a closed form has order 0 and compensated arithmetic.
struct Weight {
  std::string_view system, method;
  int order;
  std::string_view arithmetic, scalar;
  std::initializer_list<Counted> sizes;      ///< ascending in n, then in N
  std::initializer_list<AtRate> rates = {};  ///< ascending in N, then in h_omega
};

std::span<const Weight> weight_table();

/// Returns null if the table has no such entry.
const Weight* find_weight(std::string_view system, std::string_view method, int order,
                          std::string_view arithmetic, std::string_view scalar);

/// Returns n²N + n³ + 8nN, to which the operations of a step are about proportional.
double operations(double n, double N);

/// Returns the instructions of a step in a size: a power law between two sizes of the table; beyond
/// the last size that size's entry times the ratio of the two `operations`.
double instructions_at(const Weight& weight, double n, double N);

/// Returns the number of instructions at h‖Ω‖ > 0 divided by that at 0.1.
double rate_factor(const Weight& weight, double N, double h_omega);

}  // namespace stiefel
