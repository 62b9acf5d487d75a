#include "engine/accuracy/chooser.h"
#include "engine/catalogue/resolve.h"

namespace stiefel {

std::expected<Choice, Violations> choose_method(const SceneDescription& description,
                                                const Place& place) {
  if (description.members) return choose_for_members(description, place);
  auto all = candidates(description, place);
  if (!all) return std::unexpected(std::move(all.error()));
  Chooser chooser(description, place, MeasuredMotions({std::move(all->start)}), std::move(all->all),
                  Choice::most_work);
  auto chosen = chooser.choose();
  if (!chosen) return std::unexpected(std::move(chosen.error()));
  return Choice{chosen->method,       *description.tolerance,
                *description.horizon, chosen->error * *description.tolerance,
                chosen->verified,     chooser.reason(*chosen),
                chooser.work()};
}

std::expected<ChosenScene, Violations> resolve_choosing(SceneDescription description,
                                                        double largest_repair, const Place& place) {
  std::optional<Choice> choice;
  if (wants_choice(description)) {
    Violations wrong = check_before_choice(description, largest_repair, place);
    if (!wrong.empty()) return std::unexpected(std::move(wrong));
    auto chosen = choose_method(description, place);
    if (!chosen) return std::unexpected(std::move(chosen.error()));
    choice = *std::move(chosen);
    description.method = choice->method;
    description.tolerance.reset();
    description.verification.clear();
  }
  auto scene = resolve_recommending(std::move(description), largest_repair, place);
  if (!scene) return std::unexpected(std::move(scene.error()));
  return ChosenScene{*std::move(scene), std::move(choice)};
}

}  // namespace stiefel
