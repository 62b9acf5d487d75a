#include <google/protobuf/util/time_util.h>

#include <algorithm>

#include "engine/scene/near_name.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/identity.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

google::protobuf::Timestamp timestamp(std::chrono::system_clock::time_point time) {
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(since.count());
}

static_assert(same_order(Outcome::not_finite, v1::OUTCOME_REACHED) == v1::OUTCOME_NOT_FINITE);

}  // namespace

void to_proto(const Choice& choice, v1::Choice* out) {
  to_proto(choice.method, out->mutable_method());
  out->set_tolerance(choice.tolerance);
  out->set_horizon(choice.horizon);
  out->set_reason(choice.reason);
  out->set_error(choice.error);
}

void to_list(const RegisteredSession& session, const Registry& registry, v1::Session* out) {
  out->set_session_id(session.id());
  out->set_system(session.scene().system());
  out->set_numerics_id(numerics_id());
  out->set_cursor(session.cursor());
  *out->mutable_create_time() = timestamp(session.create_time());
  *out->mutable_expire_time() = timestamp(registry.expire_time(session));
}

void to_proto(const RegisteredSession& session, const Registry& registry, bool with_scene,
              v1::Session* out) {
  to_list(session, registry, out);
  if (with_scene) to_proto(session.scene().description(), out->mutable_scene());
  if (session.choice()) to_proto(*session.choice(), out->mutable_choice());
  const auto steps = session.cached_steps();
  out->mutable_cached_steps()->Add(steps.begin(), steps.end());
  for (const std::string& warning : session.warnings()) out->add_warnings(warning);
  v1::Price& price = *out->mutable_step_price();
  price.set_work(session.step_work());
  price.set_bytes(sample_bytes(session, session.default_fields()));
}

void to_proto(const RunStatus& run_status, v1::RunStatus* out) {
  if (run_status.outcome == Outcome::cancelled) throw Stopped();
  out->set_outcome(same_order(run_status.outcome, v1::OUTCOME_REACHED));
  if (run_status.largest_step) out->set_largest_step(*run_status.largest_step);
  if (run_status.member) out->set_member(static_cast<std::uint32_t>(*run_status.member));
  if (!run_status.reached()) out->set_message(to_sentence(run_status));
}

void to_proto(const Cursor& cursor, const Scene& scene, v1::RunStatus* out) {
  to_proto(cursor.run_status(), out);
  if (!cursor.run_status().reached())
    out->set_message(to_sentence(cursor.run_status(), scene, cursor.rate()));
}

std::vector<std::size_t> select_fields(const Session& session, const FieldNames& names) {
  const std::vector<Field>& offered = session.fields();
  if (names.empty()) return session.default_fields();
  std::vector<std::size_t> selected;
  Violations violations;
  const auto refuse = [&](int i, std::string rule) {
    violations.push_back({"fields[" + std::to_string(i) + "]", names[i], std::move(rule)});
  };
  for (int i = 0; i < names.size() && violations.size() < 16; ++i) {
    const auto index = find_field(offered, names[i]);
    if (!index) {
      const bool no_frame = names[i] == "Q" && !session.scene().has_frame();
      refuse(i, "must be one of " + field_names(offered) +
                    (no_frame ? "; the initial state has no Q"
                              : did_you_mean(names[i], offered, &Field::name)));
    } else if (std::ranges::find(selected, *index) != selected.end()) {
      refuse(i, "is named twice");
    } else {
      selected.push_back(*index);
    }
  }
  if (!violations.empty()) throw errors::invalid(violations);
  return selected;
}

void describe_field(const Session& session, std::size_t index, std::optional<std::size_t> samples,
                    bool of_member, v1::Field* out) {
  const Field field = field_at(session.fields(), index);
  out->set_name(field.name);
  v1::Tensor* tensor = out->mutable_value();
  tensor->set_data_type(field.complex              ? v1::DATA_TYPE_COMPLEX128
                        : is_float(session, index) ? v1::DATA_TYPE_FLOAT32
                                                   : v1::DATA_TYPE_FLOAT64);
  tensor->clear_shape();
  if (samples) tensor->add_shape(*samples);
  if (field.members > 0 && !of_member) tensor->add_shape(static_cast<std::uint64_t>(field.members));
  tensor->add_shape(static_cast<std::uint64_t>(field.rows));
  tensor->add_shape(static_cast<std::uint64_t>(field.cols));
}

v1::Field to_field(std::string_view name, std::initializer_list<Eigen::Index> shape,
                   std::span<const double> numbers) {
  v1::Field out;
  out.set_name(std::string(name));
  v1::Tensor& tensor = *out.mutable_value();
  tensor.set_data_type(v1::DATA_TYPE_FLOAT64);
  for (const Eigen::Index extent : shape) tensor.add_shape(static_cast<std::uint64_t>(extent));
  tensor.set_data(numbers.data(), numbers.size_bytes());
  return out;
}

void to_proto(const Session& session, const Simulation& simulation,
              const std::vector<std::size_t>& fields, v1::Sample* out) {
  out->set_step(simulation.step());
  out->set_time(session.scene().time(simulation.step()));
  for (const std::size_t index : fields) {
    v1::Field* to = out->add_fields();
    describe_field(session, index, std::nullopt, false, to);
    std::string& bytes = *to->mutable_value()->mutable_data();
    bytes.resize(field_bytes(session, index));
    write_field(session, simulation, index, bytes.data());
  }
}

}  // namespace stiefel::server
