#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/sessions/identity.h"
#include "stiefel/version.h"

namespace stiefel::server {
namespace {

std::string text(std::string_view view) { return std::string(view); }

v1::Side side_of(Side side) {
  return side == Side::none   ? v1::SIDE_UNSPECIFIED
         : side == Side::left ? v1::SIDE_LEFT
                              : v1::SIDE_RIGHT;
}

void describe(const SystemInfo& system, v1::SystemInfo* out) {
  out->set_name(text(system.name));
  out->set_summary(text(system.summary));
  out->set_equations(text(system.equations));
  out->set_source(text(system.source));
  out->set_file(text(system.file));
  out->set_discrete(system.discrete);
  out->set_side(side_of(system.side));
  out->set_momentum(text(system.momentum));
  out->set_velocity(text(system.velocity));
  for (const BlockInfo& block : system.blocks) {
    auto* to = out->add_blocks();
    to->set_name(text(block.name));
    to->set_shape(text(block.shape));
    to->set_required(block.required);
    to->set_description(text(block.description));
  }
  for (const FieldInfo& field : system.fields) {
    auto* to = out->add_fields();
    to->set_name(text(field.name));
    to->set_shape(text(field.shape));
    to->set_description(text(field.description));
  }
  for (const InvariantInfo& invariant : system.invariants) {
    auto* to = out->add_invariants();
    to->set_name(text(invariant.name));
    to->set_formula(text(invariant.formula));
    to->set_source(text(invariant.source));
  }
  for (const FormInfo& form : system.forms) {
    auto* to = out->add_forms();
    to->set_name(text(form.name));
    to->set_blocks(text(form.blocks[0]) + ", " + text(form.blocks[1]));
    to->set_formula(text(form.formula));
    to->set_source(text(form.source));
  }
  for (const Recommendation& one : recommended(system.name)) {
    auto* to = out->add_recommended();
    to->set_where(text(one.where));
    to_proto(one.description(), to->mutable_method());
    to->set_largest_h_omega(one.largest_h_omega);
    to->set_largest_h_momentum_rate(one.largest_h_momentum_rate);
    to->set_largest_h_velocity_rate(one.largest_h_velocity_rate);
  }
  for (const MethodOnSystem& method : system.methods) {
    auto* to = out->add_methods();
    to->set_method(text(method.method));
    to->set_where(text(method.where));
    to->set_in_float(method.in_float);
    to->set_has_tangent(method.has_tangent);
    for (const Preservation& preservation : method.preserves) {
      auto* preserves = to->add_preserves();
      preserves->set_invariant(text(preservation.invariant));
      preserves->set_conservation(to_proto(preservation.conservation));
    }
  }
}

void describe(const MethodInfo& method, v1::MethodInfo* out) {
  out->set_name(text(method.name));
  out->set_summary(text(method.summary));
  out->set_source(text(method.source));
  out->set_file(text(method.file));
  for (const int order : method.orders) out->add_orders(static_cast<std::uint32_t>(order));
  out->set_default_order(static_cast<std::uint32_t>(method.default_order));
  out->set_reversible(method.reversible);
  out->set_default_tolerance(method.default_tolerance);
}

}  // namespace

v1::Conservation to_proto(Conservation conservation) {
  switch (conservation) {
    case Conservation::exact:
      return v1::CONSERVATION_EXACT;
    case Conservation::bounded:
      return v1::CONSERVATION_BOUNDED;
    case Conservation::drifts:
      return v1::CONSERVATION_DRIFTS;
  }
  return v1::CONSERVATION_UNSPECIFIED;
}

void describe_engine(v1::DescribeResponse* out) {
  out->set_numerics_id(numerics_id());
  out->set_build(build_fingerprint());
  auto& limits = *out->mutable_limits();
  limits.set_max_dimension(Scene::max_dimension);
  limits.set_max_members(Scene::max_members);
  limits.set_max_step(Session::max_step);
  limits.set_max_cached_steps(Checkpoints::max_count);
  limits.set_max_cached_bytes(Checkpoints::max_bytes);
  limits.set_max_reply_bytes(max_reply_bytes);
  for (const SystemInfo& system : catalogue().systems) describe(system, out->add_systems());
  for (const MethodInfo& method : catalogue().methods) describe(method, out->add_methods());
}

}  // namespace stiefel::server
