#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/sessions/identity.h"
#include "stiefel/version.h"

namespace stiefel::server {
namespace {

static_assert(same_order(Side::right, v1::SIDE_UNSPECIFIED) == v1::SIDE_RIGHT);
static_assert(same_order(Conservation::drifts, v1::CONSERVATION_EXACT) == v1::CONSERVATION_DRIFTS);

using Texts = std::initializer_list<std::pair<const char*, std::string_view>>;

/// Sets fields by their names.
void write(Texts texts, google::protobuf::Message* out) {
  for (const auto& [name, text] : texts)
    out->GetReflection()->SetString(out, out->GetDescriptor()->FindFieldByName(name),
                                    std::string(text));
}

void describe(const SystemInfo& system, v1::SystemInfo* out) {
  write({{"name", system.name},
         {"summary", system.summary},
         {"equations", system.equations},
         {"source", system.source},
         {"file", system.file},
         {"momentum", system.momentum},
         {"velocity", system.velocity}},
        out);
  out->set_discrete(system.discrete);
  out->set_side(same_order(system.side, v1::SIDE_UNSPECIFIED));
  for (const BlockInfo& block : system.blocks) {
    auto* to = out->add_blocks();
    write({{"name", block.name}, {"shape", block.shape}, {"description", block.description}}, to);
    to->set_required(block.required);
  }
  for (const FieldInfo& field : system.fields)
    write({{"name", field.name}, {"shape", field.shape}, {"description", field.description}},
          out->add_fields());
  for (const InvariantInfo& one : system.invariants)
    write({{"name", one.name}, {"formula", one.formula}, {"source", one.source}},
          out->add_invariants());
  for (const FormInfo& form : system.forms) {
    auto* to = out->add_forms();
    write({{"name", form.name}, {"formula", form.formula}, {"source", form.source}}, to);
    to->set_blocks(std::string(form.blocks[0]) + ", " + std::string(form.blocks[1]));
  }
  for (const Recommendation& one : recommended(system.name)) {
    auto* to = out->add_recommended();
    to->set_where(std::string(one.where));
    to_proto(one.description(), to->mutable_method());
    to->set_largest_h_omega(one.largest_h_omega);
  }
  for (const MethodOnSystem& method : system.methods) {
    auto* to = out->add_methods();
    write({{"method", method.method}, {"where", method.where}}, to);
    to->set_in_float(method.in_float);
    to->set_has_tangent(method.has_tangent);
    for (const Preservation& preservation : method.preserves) {
      auto* preserves = to->add_preserves();
      preserves->set_invariant(std::string(preservation.invariant));
      preserves->set_conservation(same_order(preservation.conservation, v1::CONSERVATION_EXACT));
    }
  }
}

void describe(const MethodInfo& method, v1::MethodInfo* out) {
  write({{"name", method.name},
         {"summary", method.summary},
         {"source", method.source},
         {"file", method.file}},
        out);
  for (const int order : method.orders) out->add_orders(static_cast<std::uint32_t>(order));
  out->set_default_order(static_cast<std::uint32_t>(method.default_order));
  out->set_reversible(method.reversible);
  out->set_default_tolerance(method.default_tolerance);
}

}  // namespace

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
