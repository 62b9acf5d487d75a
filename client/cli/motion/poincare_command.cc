#include <algorithm>
#include <charconv>
#include <map>
#include <ranges>

#include "client/cli/input/message_file.h"
#include "client/cli/motion/motion_options.h"
#include "stiefel/client/samples.h"

namespace stiefel::cli {
namespace {

struct PoincareCommand : MotionCommand {
  std::vector<std::string> section;  ///< "q=0,0,1", terms that are added
  double level = 0;
  std::string direction = "rising";
  std::vector<std::string> coordinates;
};

/// A linear function of a field.
struct Linear {
  std::string field;
  std::vector<double> coefficients;

  /// Returns its value at event `i` of the values of the field at several events.
  double at(std::span<const double> values, std::size_t i) const {
    long double sum = 0;
    for (std::size_t k = 0; k < coefficients.size(); ++k)
      if (coefficients[k] != 0)
        sum += static_cast<long double>(coefficients[k]) * values[i * coefficients.size() + k];
    return static_cast<double>(sum);
  }
};

Linear read_linear(const std::string& option, const std::string& text) {
  const auto refuse = [&](const std::string& rule) {
    throw BadInput(option + ": " + text + ": must be FIELD=NUMBER,NUMBER,..." + rule);
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse("");
  Linear linear{text.substr(0, equals), {}};
  for (std::size_t at = equals; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at + 1), text.size());
    double number = 0;
    const char* last = text.data() + end;
    const auto [stop, error] = std::from_chars(text.data() + at + 1, last, number);
    if (error != std::errc() || stop != last)
      refuse("; " + text.substr(at + 1, end - at - 1) + " is no number");
    linear.coefficients.push_back(number);
    at = end;
  }
  return linear;
}

v1::SummarizeRequest request_of(const PoincareCommand& command, const std::vector<Linear>& section,
                                const std::vector<Linear>& coordinates) {
  static const std::map<std::string, v1::Direction> directions = {
      {"both", v1::DIRECTION_UNSPECIFIED},
      {"rising", v1::DIRECTION_RISING},
      {"falling", v1::DIRECTION_FALLING}};
  v1::SummarizeRequest request;
  request.set_every(1);
  auto& event = *request.add_events();
  const auto put = [](const Linear& of, auto& term) {
    term.set_field(of.field);
    term.mutable_coefficients()->Add(of.coefficients.begin(), of.coefficients.end());
  };
  put(section.front(), event);
  for (const Linear& of : section | std::views::drop(1)) put(of, *event.add_plus());
  event.set_level(command.level);
  event.set_direction(directions.at(command.direction));
  for (const auto* all : {&section, &coordinates})
    for (const Linear& of : *all)
      if (std::ranges::find(request.fields(), of.field) == request.fields().end())
        request.add_fields(of.field);
  return request;
}

void append_crossings(const v1::EventBatch& batch, const std::vector<Linear>& section, double level,
                      const std::vector<Linear>& coordinates, nlohmann::ordered_json& crossings) {
  const auto count = static_cast<std::size_t>(batch.steps_size());
  const auto values = [&](const Linear& of) {
    const auto field = std::ranges::find(batch.fields(), of.field, &v1::Field::name);
    const std::span<const double> all = client::values(field->value());
    if (all.size() != count * of.coefficients.size())
      throw BadInput("--coordinate: " + of.field + " has " + std::to_string(all.size() / count) +
                     " numbers, and must have as many coefficients");
    return all;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const int k = static_cast<int>(i);
    nlohmann::ordered_json point = nlohmann::ordered_json::array();
    for (const Linear& of : coordinates) point.push_back(of.at(values(of), i));
    double residual = -level;
    for (const Linear& of : section) residual += of.at(values(of), i);
    nlohmann::ordered_json crossing = {{"step", batch.steps(k)},
                                       {"fraction", batch.fractions(k)},
                                       {"time", batch.times(k)},
                                       {"point", std::move(point)},
                                       {"residual", residual}};
    if (batch.members_size() > 0) crossing["member"] = batch.members(k);
    crossings.push_back(std::move(crossing));
  }
}

ExitStatus poincare(const PoincareCommand& command, Origin& origin) {
  std::vector<Linear> section, coordinates;
  for (const std::string& text : command.section) section.push_back(read_linear("--section", text));
  for (const std::string& text : command.coordinates)
    coordinates.push_back(read_linear("--coordinate", text));
  nlohmann::ordered_json crossings = nlohmann::ordered_json::array();
  const auto ask = [&](const auto& session, const auto& request, Progress& progress) {
    return session.summarize(request, [&](const v1::SummarizeResponse& message) {
      progress.at(message.step());
      if (message.events().steps_size() > 0)
        append_crossings(message.events(), section, command.level, coordinates, crossings);
      return true;
    });
  };
  return answer(command, origin, request_of(command, section, coordinates), ask,
                [&](auto& json, const auto&) { json["crossings"] = std::move(crossings); });
}

void add_poincare(CLI::App* app, Command& chosen) {
  const auto command = std::make_shared<PoincareCommand>();
  add_motion(app, *command, "the step after which crossings count; 0 by default");
  app->add_option(
         "--section", command->section,
         "the plane sum(NUMBER * FIELD) = level; the numbers row by row: q=0,0,1. Repeatable: "
         "the sums are added")
      ->required()
      ->type_name("FIELD=NUMBER,...");
  app->add_option("--level", command->level, "0 by default")->type_name("NUMBER");
  app->add_option("--direction", command->direction, "rising (the default), falling or both")
      ->check(CLI::IsMember({"rising", "falling", "both"}));
  app->add_option("--coordinate", command->coordinates,
                  "a linear function of a field, which is a number of each point. Repeatable")
      ->type_name("FIELD=NUMBER,...");
  add_end(app, chosen, command, {{"events", "--section"}, {"fields", "--coordinate"}}, poincare);
}

const Subcommand poincare_command("poincare",
                                  "Prints where a motion crosses a plane in the space of states",
                                  add_poincare);

}  // namespace

}  // namespace stiefel::cli
