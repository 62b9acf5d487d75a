#include <algorithm>
#include <cctype>
#include <functional>
#include <numeric>

#include "client/cli/input/message_file.h"
#include "client/cli/input/nested_numbers.h"
#include "client/cli/motion/motion_options.h"
#include "client/cli/sinks/description.h"

namespace stiefel::cli {
namespace {

struct SummarizeCommand : MotionCommand {
  std::int64_t every = 1;
  /// "energy=drift", "M=min,max".
  std::vector<std::string> quantities;
  /// A file with `quantities`, `events` and `fields`, as in stiefel.v1.SummarizeRequest.
  std::string request;
  bool over_members = false;
};

/// Reads a quantity such as "energy=drift,last".
v1::Quantity read_quantity(const std::string& text, bool over_members) {
  v1::Quantity quantity;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw BadInput("--quantity: " + text + ": must be NAME=STATISTIC,...");
  quantity.set_name(text.substr(0, equals));
  quantity.set_over_members(over_members);
  for (std::size_t at = equals; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at + 1), text.size());
    std::string name = text.substr(at + 1, end - at - 1);
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
    v1::Statistic statistic;
    if (!v1::Statistic_Parse("STATISTIC_" + name, &statistic))
      throw BadInput("--quantity: " + text +
                     ": must name last, min, max, mean, rms, sign_changes or drift");
    quantity.add_statistics(statistic);
    at = end;
  }
  return quantity;
}

/// Reads a file with quantities, events and fields, and refuses what options of the command say.
v1::SummarizeRequest read_request(const std::string& file) {
  v1::SummarizeRequest request;
  read_message(file, &request);
  std::vector<const google::protobuf::FieldDescriptor*> given;
  request.GetReflection()->ListFields(request, &given);
  for (const auto* field : given) {
    const std::string& name = field->name();
    if (name != "quantities" && name != "events" && name != "fields")
      throw BadInput(file + ": " + name +
                     ": must be absent; the file may have quantities, events " + "and fields");
  }
  return request;
}

v1::SummarizeRequest request_of(const SummarizeCommand& command) {
  v1::SummarizeRequest request;
  if (!command.request.empty()) request = read_request(command.request);
  request.set_every(command.every);
  if (command.over_members)
    for (auto& quantity : *request.mutable_quantities()) quantity.set_over_members(true);
  for (const std::string& text : command.quantities)
    *request.add_quantities() = read_quantity(text, command.over_members);
  return request;
}

/// Returns a statistic "QUANTITY.NAME" as nested lists; a number of a single motion is a number.
nlohmann::ordered_json statistic(const v1::Field& field) {
  const std::size_t dot = field.name().rfind('.');
  const std::string name = field.name().substr(dot + 1);
  const auto& shape = field.value().shape();
  return as_lists(field.value(),
                  named_shape(field.name().substr(0, dot), {shape.begin(), shape.end()},
                              name == "quantiles" || name == "histogram"));
}

void append_events(const v1::EventBatch& batch, nlohmann::ordered_json& events) {
  for (int i = 0; i < batch.steps_size(); ++i) {
    nlohmann::ordered_json event = {{"event", batch.events(i)},
                                    {"step", batch.steps(i)},
                                    {"fraction", batch.fractions(i)},
                                    {"time", batch.times(i)}};
    if (batch.members_size() > 0) event["member"] = batch.members(i);
    for (const auto& field : batch.fields()) {
      const auto shape = sample_shape(field);
      const std::size_t each =
          std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies{});
      event["fields"][field.name()] =
          as_lists(field.value(), shape, each * static_cast<std::size_t>(i));
    }
    events.push_back(std::move(event));
  }
}

nlohmann::ordered_json outcomes(const v1::Tensor& tensor) {
  nlohmann::ordered_json out = as_lists(tensor);
  for (auto& outcome : out) outcome = to_string(static_cast<v1::Outcome>(outcome.get<int>()));
  return out;
}

/// Adds the statistics. In an ensemble each member has an outcome.
void append_statistics(const v1::SummarizeResponse& end, nlohmann::ordered_json& json) {
  auto& statistics = json["statistics"] = nlohmann::ordered_json::object();
  for (const auto& field : end.statistics()) {
    const bool of_quantity = field.name().find('.') != std::string::npos;
    if (of_quantity)
      statistics[field.name()] = statistic(field);
    else if (field.name() == "outcome" && field.value().shape_size() > 0)
      json["outcomes"] = outcomes(field.value());
    else if (field.name() != "outcome")
      json[field.name()] = as_lists(field.value());
  }
}

ExitStatus summarize(const SummarizeCommand& command, Origin& origin) {
  if (command.every <= 0)
    throw BadInput("--every: " + std::to_string(command.every) + " must be positive");
  const v1::SummarizeRequest request = request_of(command);
  if (request.quantities().empty() && request.events().empty())
    throw BadInput("summarize: give --quantity, or --request with quantities or events");
  nlohmann::ordered_json events;
  if (!request.events().empty()) events = nlohmann::ordered_json::array();
  const auto ask = [&](const auto& session, const auto& whole, Progress& progress) {
    return session.summarize(whole, [&](const v1::SummarizeResponse& message) {
      progress.at(message.step());
      append_events(message.events(), events);
      return true;
    });
  };
  return answer(command, origin, request, ask, [&](auto& json, const auto& end) {
    append_statistics(end, json);
    if (!events.is_null()) json["events"] = std::move(events);
  });
}

void add_summarize(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<SummarizeCommand>();
  add_motion(app, *command, "the first sample; 0 by default");
  app->add_option("--every", command->every,
                  "a sample every K steps, and always at the last step; 1 by default")
      ->transform(whole_number())
      ->type_name("K");
  app->add_option("--quantity", command->quantities,
                  "NAME is a field, an invariant or a family of invariants; A,B,... are among "
                  "last, min, max, mean, rms, sign_changes, drift. Repeatable. Example: "
                  "energy=drift")
      ->type_name("NAME=A,B,...");
  app->add_flag("--over-members", command->over_members,
                "one statistic over the members of an ensemble instead of one for each");
  app->add_option(
         "--request", command->request,
         "file with `quantities` (which may have quantiles and edges), `events` and `fields`: the "
         "JSON form of stiefel.v1.SummarizeRequest")
      ->type_name("FILE.json");
  add_end(app, chosen, command,
          {{"every", "--every"}, {"events", "--request: events"}, {"fields", "--request: fields"}},
          summarize);
}

const Subcommand summarize_command("summarize",
                                   "Prints statistics and events of a motion without its samples",
                                   add_summarize);

}  // namespace

}  // namespace stiefel::cli
