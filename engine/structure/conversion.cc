#include "stiefel/conversion.h"

#include <algorithm>
#include <cmath>

#include "engine/motion/representation.h"
#include "engine/motion/system_entry.h"
#include "engine/numbers/to_text.h"
#include "engine/scene/near_name.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"

namespace stiefel {
namespace {

/// Returns the representation of a system, or of one of `other_targets`; null where there is none.
const Representation* representation_of(std::string_view name) {
  if (const SystemEntry* entry = system_entry(name)) return entry->representation;
  constexpr const Representation* others[] = {&representations::velocity,
                                              &representations::angular_velocity,
                                              &representations::interpolation};
  static_assert(std::size(others) == std::size(other_targets));
  const auto found = std::ranges::find(other_targets, name);
  return found == std::end(other_targets) ? nullptr : others[found - std::begin(other_targets)];
}

std::unexpected<ConversionRefusal> refuse(Violation violation) {
  return std::unexpected(ConversionRefusal(Violations{std::move(violation)}));
}

/// Returns the rule "must be a system or one of velocity, ...", with the name nearest to the given
/// one.
std::string rule_of_targets(std::string_view given) {
  std::vector<std::string_view> known;
  for (const SystemInfo& system : catalogue().systems) known.push_back(system.name);
  std::string others;
  for (const char* name : other_targets) {
    others.append(others.empty() ? "" : ", ").append(name);
    known.push_back(name);
  }
  return "must be a system or one of " + others + did_you_mean(given, known);
}

/// Returns the violation of a number that the target does not have; nullopt if there is none.
std::optional<Violation> useless_number(const ConversionTarget& target, const Representation* to) {
  const bool epsilon = target.epsilon && !(to && to->has_epsilon);
  const bool parameter = target.parameter && !(to && to->has_parameter);
  if (!epsilon && !parameter) return std::nullopt;
  return Violation{epsilon ? "epsilon" : "parameter",
                   to_text(epsilon ? *target.epsilon : *target.parameter),
                   "must be absent in a conversion to " + target.name};
}

/// Whether a field is a number that the target gives.
bool is_of_target(std::string_view field, const ConversionTarget& target) {
  return (target.epsilon && field == "epsilon") || (target.parameter && field == "parameter");
}

/// Returns a refusal of an argument (`outside`), which is "to" or a number of the target, or else a
/// field of the scene.
ConversionRefusal refused(OutsideDomain refusal, const ConversionTarget& target) {
  if (refusal.field != "to" && refusal.field != "epsilon" && !is_of_target(refusal.field, target))
    refusal.field.insert(0, "scene.");
  return refusal;
}

/// Returns the violations of the resulting scene as those of the target.
Violations of_target(Violations wrong, const ConversionTarget& target) {
  for (Violation& one : wrong) {
    if (is_of_target(one.field, target)) continue;
    if (!one.field.empty()) one.value = one.field + ": " + one.value;
    one.field = "to";
  }
  return wrong;
}

std::optional<MethodDescription> method_on(const SystemInfo& system, const Scene& scene) {
  const auto& given = scene.description().method;
  for (const auto& on : system.methods)
    if (given && on.method == given->name) return given;
  return std::nullopt;
}

SceneDescription describe(const Scene& scene, const SystemInfo& system, const Phase& phase,
                          const FormBlocks& expression) {
  SceneDescription out;
  out.system = system.name;
  out.method = method_on(system, scene);
  out.inertia = {phase.lambda.begin(), phase.lambda.end()};
  for (const auto& [name, block] : expression.blocks) out.initial[name] = Block(block);
  out.epsilon = expression.epsilon;
  out.parameter = expression.parameter;
  out.step = scene.step();
  return out;
}

/// Returns the index of the field that starts a scene in place of field `i`. It is the index of M
/// for P in an ensemble without a common ε, because each member chooses its ε from M; otherwise
/// `i`.
std::size_t starting(const Scene& scene, const Simulation& now, std::size_t i) {
  const auto index = [&](std::string_view name) {
    const auto found = std::ranges::find(now.fields(), name, &Field::name);
    return static_cast<std::size_t>(found - now.fields().begin());
  };
  const bool own_epsilons = !scene.members().empty() && !scene.description().epsilon &&
                            index("epsilon") < now.fields().size();
  return own_epsilons && now.fields()[i].name == "P" ? index("M") : i;
}

Block block_of(const Simulation& now, std::size_t index) {
  const Field& field = now.fields()[index];
  const int rows = field.rows * std::max(1, field.members);
  RowMatrix numbers(rows, field.size() / rows);
  now.write(index, {numbers.data(), static_cast<std::size_t>(numbers.size())});
  if (!field.complex) return numbers;
  RowMatrix real(rows, field.cols), imaginary(rows, field.cols);
  for (Eigen::Index j = 0; j < field.cols; ++j) {
    real.col(j) = numbers.col(2 * j);
    imaginary.col(j) = numbers.col(2 * j + 1);
  }
  return {real, imaginary};
}

}  // namespace

std::expected<Conversion, ConversionRefusal> convert(const Scene& scene,
                                                     const ConversionTarget& target) {
  const Representation* from = representation_of(scene.system());
  const Representation* to = representation_of(target.name);
  const SystemInfo* system = catalogue().system(target.name);
  if (to == nullptr && system == nullptr)
    return refuse({"to", target.name, rule_of_targets(target.name)});
  if (const auto& epsilon = target.epsilon; epsilon && !(std::isfinite(*epsilon) && *epsilon != 0))
    return refuse({"epsilon", to_text(*epsilon), "must be finite and not 0"});
  if (const auto& mu = target.parameter; mu && !std::isfinite(*mu))
    return refuse({"parameter", to_text(*mu), "must be finite"});
  if (auto useless = useless_number(target, to)) return refuse(*std::move(useless));
  Conversion out;
  if (target.name == scene.system() && !target.epsilon && !target.parameter &&
      !scene.description().body) {
    out.scene = scene;
    return out;
  }
  if (from == nullptr || from->read == nullptr)
    return refuse({"scene.system", scene.system(), "cannot be converted to other variables"});
  if (to == nullptr) return refuse({"to", target.name, "cannot be reached from " + scene.system()});
  if (const std::size_t members = scene.members().size(); members > 0)
    return refuse({"scene.members", std::to_string(members),
                   "must be absent: convert the scene of each member"});
  if (from->square && !scene.has_frame())
    return refuse(
        {"scene.initial.Q", "absent", "must be given: a momentum alone cannot be converted"});

  const auto phase = from->read(scene, out.margins);
  if (!phase) return std::unexpected(refused(phase.error(), target));
  if (to->square && !phase->square())
    return refuse({"to", target.name,
                   "needs n = N: Q is " + std::to_string(phase->Q.rows()) + " x " +
                       std::to_string(phase->Q.cols())});
  ConversionTarget wanted = target;
  if (!wanted.parameter) wanted.parameter = scene.description().parameter;
  auto expression = to->write(*phase, wanted, out.margins);
  if (!expression) return std::unexpected(refused(expression.error(), target));
  if (system == nullptr) {
    out.blocks = std::move(expression->blocks);
    return out;
  }
  SceneDescription description = describe(scene, *system, *phase, *expression);
  auto made = resolve_recommending(description, Scene::frame_tolerance);
  if (!made && description.method) {  // a method that these units do not allow in the new variables
    description.method.reset();
    if (auto other = resolve_recommending(std::move(description), Scene::frame_tolerance))
      made = std::move(other);
  }
  if (!made) return std::unexpected(ConversionRefusal(of_target(std::move(made.error()), target)));
  out.scene = *std::move(made);
  return out;
}

std::expected<Scene, Violations> scene_at(const Scene& scene, const Simulation& now) {
  if (now.step() == 0) return scene;
  SceneDescription out = scene.description();
  const auto numbers = [&](const char* field) {
    const RowMatrix v = now.get(field);
    return std::vector<double>(v.data(), v.data() + v.size());
  };
  if (out.body) {
    out.body->attitude = numbers("quaternion");
    out.body->angular_velocity = numbers("angular_velocity");
    return Scene::resolve(std::move(out), Scene::drift_tolerance);
  }
  out.initial.clear();
  for (std::size_t i = 0; i < now.block_count(); ++i) {
    const std::size_t from = starting(scene, now, i);
    out.initial[now.fields()[from].name] = block_of(now, from);
  }
  return Scene::resolve(std::move(out), Scene::drift_tolerance);
}

}  // namespace stiefel
