#include "engine/catalogue/series_start.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "engine/rigid_body/symmetric_data.h"

namespace stiefel {
namespace {

constexpr auto start = [](const auto& g) {
  using Dense = decltype(g.block("Q"));
  const Dense Q = g.block("Q"), A = constant_A(Q, g.block("P")), of_m = A - A.transpose();
  return g.start(Q, Q.transpose() * of_m * Q / g.epsilon);
};

}  // namespace

SystemEntry reduced_rigid_body_entry() {
  SystemEntry entry = symmetric_family();
  SystemInfo& info = entry.info;
  info.name = "reduced_rigid_body";
  info.summary = "symmetric representation with its constant P Q^T taken out";
  info.equations = "Q' = Q J^-1(Q^T (A - A^T) Q) / epsilon, A = P Q^T constant, P = A Q";
  info.source = "[RB] (8.2)";
  info.file = "engine/rigid_body/reduced_rigid_body.cc";
  as_view_of_pair(entry);
  entry.motion = &in_both<body_equations, start>;
  return entry;
}

Simulations reduced_rigid_body_simulations() { return rigid_body_simulations(); }

}  // namespace stiefel
