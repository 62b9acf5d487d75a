#include "client/cpp/replies.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <ranges>
#include <span>

#include "stiefel/client/error.h"

namespace stiefel::client {
namespace {

using google::protobuf::FieldDescriptor;

/// Returns the name of a statistic in the names of arrays: "sign_changes".
std::string name_of(int statistic) {
  std::string name = v1::Statistic_Name(statistic).substr(sizeof("STATISTIC_") - 1);
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

/// Whether each array has counts (INT64) or numbers, by its name.
std::map<std::string, bool> statistics_of(const v1::SummarizeRequest& request) {
  std::map<std::string, bool> counts;
  for (const char* name : {"outcome", "last_step", "ended_by", "samples"}) counts[name] = true;
  for (const auto& quantity : request.quantities()) {
    const std::string begin = quantity.name() + ".";
    for (const int statistic : quantity.statistics())
      counts[begin + name_of(statistic)] = statistic == v1::STATISTIC_SIGN_CHANGES;
    if (!quantity.quantiles().empty()) counts[begin + "quantiles"] = false;
    if (!quantity.edges().empty()) counts[begin + "histogram"] = true;
  }
  return counts;
}

}  // namespace

void require(bool holds, const std::string& fault) {
  if (!holds) throw CorruptReply("the reply breaks the protocol: " + fault);
}

void check_present(const google::protobuf::Message& message,
                   std::initializer_list<const char*> names) {
  for (const char* name : names) {
    const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
    const auto* reflection = message.GetReflection();
    require(field->is_repeated() ? reflection->FieldSize(message, field) > 0
                                 : reflection->HasField(message, field),
            message.GetDescriptor()->name() + " has no " + name);
  }
}

void check_session(const v1::Session& session, const std::string& id, bool with_scene) {
  check_present(session, {"session_id", "system", "numerics_id"});
  if (with_scene) check_present(session, {"scene", "step_price"});
  require(session.session_id() == id, "the session is " + session.session_id() + ", not " + id);
  check_blocks(session.scene());
}

void check_blocks(const v1::Scene& scene) {
  for (const auto& [name, block] : scene.initial()) {
    const std::uint64_t numbers = std::uint64_t{block.rows()} * block.cols();
    require(std::cmp_equal(block.values_size(), numbers) &&
                (block.imaginary().empty() || std::cmp_equal(block.imaginary_size(), numbers)),
            "block " + name + " does not have rows x cols numbers");
  }
}

void check_outcome(const v1::RunStatus& status) {
  require(status.outcome() != v1::OUTCOME_UNSPECIFIED && v1::Outcome_IsValid(status.outcome()),
          "Outcome " + std::to_string(status.outcome()));
}

void check_end(const v1::RunStatus& status, std::int64_t step, std::int64_t to) {
  check_outcome(status);
  const bool reached = status.outcome() == v1::OUTCOME_REACHED;
  require(reached ? step == to : 0 <= step && step < to, v1::Outcome_Name(status.outcome()) +
                                                             " at step " + std::to_string(step) +
                                                             " of " + std::to_string(to));
}

std::int64_t last_step(const google::protobuf::Message& request) {
  const auto* to = request.GetDescriptor()->FindFieldByName("to");
  const bool is_step = to != nullptr && to->cpp_type() == to->CPPTYPE_INT64;
  return is_step ? request.GetReflection()->GetInt64(request, to) : 0;
}

void check_reply(const google::protobuf::Message& reply, const google::protobuf::Message& request) {
  const auto& type = *reply.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const auto& field = *type.field(i);
    if (field.message_type() != nullptr && !field.is_repeated() && !field.containing_oneof())
      check_present(reply, {field.name().c_str()});
  }
  const auto& reflection = *reply.GetReflection();
  const auto* ended = type.FindFieldByName("run_status");
  if (ended == nullptr) return;
  const auto& status = dynamic_cast<const v1::RunStatus&>(reflection.GetMessage(reply, ended));
  const auto* step = type.FindFieldByName("step");
  if (step == nullptr) return check_outcome(status);
  check_end(status, reflection.GetInt64(reply, step), last_step(request));
}

void check_step(const v1::StepResponse& reply, std::int64_t to, const Layout::Names& fields,
                bool with_checkpoint) {
  check_present(reply, {"run_status", "sample", "price"});
  if (with_checkpoint) check_present(reply, {"checkpoint"});
  check_end(reply.run_status(), reply.sample().step(), to);
  for (const auto& field : reply.sample().fields()) check_complete(field);
  Layout(fields, 2, true).check(reply.sample().fields(), std::nullopt);
}

void check_diagnosis(const v1::DiagnoseResponse& reply, const v1::DiagnoseRequest& request) {
  require(reply.forms_size() == request.forms_size() &&
              reply.dirac_brackets_size() == request.dirac_brackets_size(),
          "it does not have the forms and brackets that were asked for");
  if (!request.invariants().empty()) check_present(reply, {"invariants"});
  for (const auto& invariant : reply.invariants()) check_present(invariant, {"name"});
  if (request.estimate_error() == v1::ERROR_ESTIMATION_ALWAYS)
    check_present(reply, {"estimated_error"});
}

void check_geodesic(const v1::ConnectResponse& reply, const v1::ConnectRequest& request) {
  check_present(reply, {"run_status", "price"});
  check_outcome(reply.run_status());
  const bool reached = reply.run_status().outcome() == v1::OUTCOME_REACHED;
  require(reply.has_velocity() == (reached && request.steps() == 0), "a geodesic has a velocity");
  if (!reached) return;
  check_present(reply, {"shortest"});
  const auto& pair = request.pairs(static_cast<int>(reply.pair()));
  const std::uint64_t n = pair.has_q_0() ? pair.q_0().rows() : pair.q_0_tensor().shape(0),
                      N = pair.has_q_0() ? pair.q_0().cols() : pair.q_0_tensor().shape(1);
  const bool bent = (request.metric() == v1::METRIC_CANONICAL ||
                     (request.metric() == v1::METRIC_BETA && request.beta() != 1)) &&
                    1 < n && n < N;
  require(reply.has_scene() == (request.view() != v1::GEODESIC_VIEW_VELOCITY && !bent),
          "the scene is not what was asked for");
  if (reply.has_scene()) check_blocks(reply.scene());
  require(v1::Shortest_IsValid(reply.shortest()), "Shortest " + std::to_string(reply.shortest()));
  const std::uint64_t steps = request.steps() > 0 ? request.steps() : request.samples();
  const auto& shape = reply.trajectory().value().shape();
  const bool as_asked =
      steps == 0
          ? !reply.has_trajectory()
          : reply.trajectory().value().data_type() == v1::DATA_TYPE_FLOAT64 &&
                std::ranges::equal(shape, std::initializer_list<std::uint64_t>{steps + 1, n, N});
  require(as_asked, "the trajectory is not the one that was asked for");
}

void check_statistics(const Fields& statistics, const v1::SummarizeRequest& request,
                      v1::Outcome run) {
  auto counts = statistics_of(request);
  for (const auto& array : statistics) {
    const auto found = counts.find(array.name());
    require(found != counts.end(), "it has the statistic " + array.name());
    require(found->second == (array.value().data_type() == v1::DATA_TYPE_INT64),
            array.name() + " has another data type");
    counts.erase(found);
    if (array.name() != "outcome") continue;
    const auto* numbers = reinterpret_cast<const std::int64_t*>(array.value().data().data());
    const std::span outcomes(numbers, array.value().data().size() / sizeof(std::int64_t));
    require(!outcomes.empty() && std::ranges::all_of(outcomes,
                                                     [](std::int64_t outcome) {
                                                       return v1::OUTCOME_UNSPECIFIED < outcome &&
                                                              outcome <= v1::Outcome_MAX;
                                                     }),
            "it has an unknown outcome");
    const bool all = std::ranges::all_of(outcomes, [](auto o) { return o == v1::OUTCOME_REACHED; });
    require(all == (run == v1::OUTCOME_REACHED),
            v1::Outcome_Name(run) + ", and its motions say something else");
  }
  require(counts.empty(), "it has no " + (counts.empty() ? "" : counts.begin()->first));
}

void Layout::check(const Fields& fields, std::optional<int> count) {
  std::vector<std::string> names, found;
  for (const auto& field : fields) {
    const auto& shape = field.value().shape();
    const int axes = shape.size(), most = axes_ + (members_ ? 1 : 0);
    require(axes_ <= axes && axes <= most && (!count || std::cmp_equal(shape[0], *count)) &&
                field.value().data_type() != v1::DATA_TYPE_INT64,
            field.name() + " has another shape or data type");
    names.push_back(field.name());
    found.push_back(field.name() + " " + std::to_string(field.value().data_type()));
    for (int axis = count ? 1 : 0; axis < axes; ++axis)
      found.back().append(" ").append(std::to_string(shape[axis]));
  }
  require(!names.empty() && (wanted_.empty() || std::ranges::is_permutation(names, wanted_)),
          "it does not have the fields that were asked for");
  if (!first_) first_ = found;
  require(*first_ == found, "its fields have other shapes than those before");
}

void Steps::check(const v1::StreamResponse& batch) {
  require(batch.times_size() == batch.steps_size(), "it has steps without times");
  for (const std::int64_t step : batch.steps()) {
    require(!over_ && 0 <= step && step <= next_, "its samples are not those that come next");
    over_ = step < next_ || step == to_;
    next_ = to_ - next_ > every_ ? next_ + every_ : to_;
  }
}

void Steps::end(const v1::RunStatus& status, std::optional<std::int64_t> last) const {
  check_outcome(status);
  require((status.outcome() == v1::OUTCOME_REACHED) == (last == to_),
          v1::Outcome_Name(status.outcome()) + ", and its last sample says something else");
}

void TradeoffParts::check(const v1::MeasureTradeoffResponse& part) {
  using Part = v1::MeasureTradeoffResponse;
  const auto kind = part.part_case();
  require((kind == Part::kSetup) == !begun() && kind != Part::PART_NOT_SET && last_ != Part::kFront,
          "a part of the trade-off comes out of order");
  last_ = kind;
  if (part.has_setup()) {
    check_present(part.setup(), {"machine", "numerics_id", "reference", "price"});
  } else if (part.has_point()) {
    ++points_;
    check_present(part.point(), {"method", "run_status"});  // no times where the first step failed
    check_outcome(part.point().run_status());
    require(part.point().has_momentum_error() ==
                (part.point().run_status().outcome() == v1::OUTCOME_REACHED),
            "a point has an error where its run has REACHED the horizon");
  } else {
    require(std::ranges::all_of(part.front().points(), [&](auto i) { return i < points_; }),
            "the front is not of its points");
  }
}

void TradeoffParts::end() const {
  require(last_ == v1::MeasureTradeoffResponse::kFront, "the front is missing");
}

}  // namespace stiefel::client
