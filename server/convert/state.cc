#include <algorithm>

#include "engine/scene/near_name.h"
#include "server/convert/convert.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::server {
namespace {

v1::Outcome outcome(Outcome value) {
  switch (value) {
    case Outcome::reached:
      return v1::OUTCOME_REACHED;
    case Outcome::left_domain:
      return v1::OUTCOME_LEFT_DOMAIN;
    case Outcome::solver_stalled:
      return v1::OUTCOME_SOLVER_STALLED;
    case Outcome::not_finite:
      return v1::OUTCOME_NOT_FINITE;
    case Outcome::cancelled:
      return v1::OUTCOME_CANCELLED;
  }
  return v1::OUTCOME_UNSPECIFIED;
}

}  // namespace

void to_proto(const RunStatus& run_status, v1::RunStatus* out) {
  out->set_outcome(outcome(run_status.outcome));
  if (run_status.largest_step) out->set_largest_step(*run_status.largest_step);
  if (run_status.member) out->set_member(static_cast<std::uint32_t>(*run_status.member));
  if (!run_status.reached()) out->set_message(to_sentence(run_status));
}

void to_proto(const Cursor& cursor, const Scene& scene, v1::RunStatus* out) {
  to_proto(cursor.run_status(), out);
  if (!cursor.run_status().reached())
    out->set_message(to_sentence(cursor.run_status(), scene, cursor.rate()));
}

std::expected<std::vector<std::size_t>, Violations> select_fields(const Session& session,
                                                                  const FieldNames& names) {
  const std::vector<Field>& offered = session.fields();
  if (names.empty()) return session.default_fields();
  std::vector<std::size_t> selected;
  Violations violations;
  const auto refuse = [&](int i, std::string rule) {
    violations.push_back({"fields[" + std::to_string(i) + "]", names[i], std::move(rule)});
  };
  for (int i = 0; i < names.size() && violations.size() < 16; ++i) {
    const auto found = std::ranges::find(offered, names[i], &Field::name);
    const auto index = static_cast<std::size_t>(found - offered.begin());
    if (found == offered.end()) {
      std::string rule;
      for (const Field& field : offered) rule += (rule.empty() ? "" : ", ") + field.name;
      refuse(i, "must be one of " + rule + did_you_mean(names[i], offered, &Field::name));
    } else if (std::ranges::find(selected, index) != selected.end()) {
      refuse(i, "is named twice");
    } else {
      selected.push_back(index);
    }
  }
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return selected;
}

void describe_field(const Session& session, const Field& field, std::optional<std::size_t> samples,
                    v1::Field* out) {
  out->set_name(field.name);
  v1::Tensor* tensor = out->mutable_value();
  tensor->set_data_type(field.complex              ? v1::DATA_TYPE_COMPLEX128
                        : is_float(session, field) ? v1::DATA_TYPE_FLOAT32
                                                   : v1::DATA_TYPE_FLOAT64);
  tensor->clear_shape();
  if (samples) tensor->add_shape(*samples);
  if (field.members > 0) tensor->add_shape(static_cast<std::uint64_t>(field.members));
  tensor->add_shape(static_cast<std::uint64_t>(field.rows));
  tensor->add_shape(static_cast<std::uint64_t>(field.cols));
}

void to_proto(const Session& session, const Simulation& simulation,
              const std::vector<std::size_t>& fields, v1::Sample* out) {
  out->set_step(simulation.step());
  out->set_time(session.scene().time(simulation.step()));
  for (const std::size_t index : fields) {
    const Field& field = session.fields()[index];
    v1::Field* to = out->add_fields();
    describe_field(session, field, std::nullopt, to);
    std::string& bytes = *to->mutable_value()->mutable_data();
    bytes.resize(field_bytes(session, field));
    write_field(session, simulation, index, bytes.data());
  }
}

}  // namespace stiefel::server
