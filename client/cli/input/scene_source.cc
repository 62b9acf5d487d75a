#include "client/cli/input/scene_source.h"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ranges>

#include "client/cli/exit_status.h"
#include "client/cli/input/embedded.h"
#include "client/cli/input/message_file.h"
#include "client/cli/input/scene_forms.h"
#include "engine/scene/near_name.h"

namespace stiefel::cli {
namespace {

std::string example_name(const EmbeddedFile& example) {
  return std::string(example.name.substr(0, example.name.rfind('.')));
}

/// Returns the value of a change: JSON, numbers or texts separated by commas, or a text.
nlohmann::json value_of(const std::string& text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_discarded()) return json;
  if (text.find(',') == std::string::npos) return text;
  auto list = nlohmann::json::array();
  for (const auto part : std::views::split(text, ','))
    list.push_back(value_of(std::string(part.begin(), part.end())));
  return list;
}

/// Sets the field at a path such as "body.moments". A null removes it.
void change(nlohmann::json& scene, const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw BadInput("--set " + text +
                   ": must be FIELD=VALUE, such as body.angular_velocity=0.1,1,0.2");
  nlohmann::json* place = &scene;
  for (const auto part : std::views::split(text.substr(0, equals), '.')) {
    const std::string name(part.begin(), part.end());
    if (!place->is_object())
      throw BadInput("--set " + text + ": " + name + " would be inside of what is no object");
    place = &(*place)[name];
    if (place->is_null()) *place = nlohmann::json::object();
  }
  *place = value_of(text.substr(equals + 1));
}

}  // namespace

std::string read_source(const std::string& given) {
  for (const EmbeddedFile& example : examples())
    if (given == example_name(example)) return std::string(example.text);
  if (given == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  const bool plain = given.find_first_of("./") == std::string::npos;
  if (plain && !std::filesystem::exists(given)) {
    std::vector<std::string> names;
    for (const EmbeddedFile& example : examples()) names.push_back(example_name(example));
    const auto near = near_name(given, names);
    throw BadInput(
        given + ": there is no such file, and no example has this name; " +
        (near ? "did you mean " + *near + "?"
              : "the examples are " + listed(names, [](const auto& one) { return one; })));
  }
  return read_text(given);
}

v1::Scene read_scene(const SceneSource& source, Origin& origin, std::string* epoch) {
  v1::Scene scene;
  const std::string name = source.shown(), text = read_source(source.name);
  const auto read = [&](const std::string& shown, const std::string& json) {
    scene.Clear();
    parse_messages(shown, json, {&scene}, beside_the_scene(), [&](nlohmann::json& object) {
      if (const auto instant = object.value("epoch", nlohmann::json());
          epoch && instant.is_string())
        *epoch = instant.get<std::string>();
      origin.renamed = write_out_forms(shown, object);
    });
  };
  if (source.changes.empty()) {
    read(name, text);
    return scene;
  }
  parse_messages(name, text, {&scene}, beside_the_scene(), [](nlohmann::json& object) {
    object = nlohmann::json::object();  // the forms may be complete only with the changes
  });
  auto json = nlohmann::json::parse(without_mark(name, text));
  for (const std::string& one : source.changes) {
    write_out_method(json);
    change(json, one);
  }
  read(name + " with --set", json.dump());
  return scene;
}

double in_steps(double time, double step) {
  const double steps = time / step, whole = std::nearbyint(steps);
  return std::abs(steps - whole) <= 0x3p-53 * whole ? whole : steps;
}

double end_in_steps(const SceneSource& source, const v1::Scene& scene) {
  if (source.to) return static_cast<double>(*source.to);
  if (!source.time && !scene.has_horizon())
    throw BadInput("--to is required, or --time: the scene has no horizon");
  if (!scene.has_step() || scene.step() == 0)
    throw BadInput(source.shown() + ": step: absent: must be given, finite and not 0");
  const double time = source.time ? *source.time : std::copysign(scene.horizon(), scene.step());
  const double steps = in_steps(time, scene.step());
  if (!(steps >= 0 && steps <= 0x1p53))
    throw BadInput("--time: " + nlohmann::json(time).dump() +
                   ": must be in the direction of the scene's step, within 2^53 steps");
  return steps;
}

std::int64_t last_step(const SceneSource& source, const v1::Scene& scene) {
  if (source.to) return *source.to;
  const double steps = end_in_steps(source, scene);
  const auto time = [&](double k) { return nlohmann::json(k * scene.step()).dump(); };
  if (steps != std::floor(steps))
    throw BadInput("--time: " + time(steps) + " must be a whole number of steps of " +
                   nlohmann::json(scene.step()).dump() + " s; the states next to it are at " +
                   time(std::floor(steps)) + " and " + time(std::ceil(steps)));
  return static_cast<std::int64_t>(steps);
}

}  // namespace stiefel::cli
