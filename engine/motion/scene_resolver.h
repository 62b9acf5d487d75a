#pragma once

#include "engine/scene/scene_draft.h"

namespace stiefel {

/// Checks the method of a draft, which must have one, against those of a continuous system, and
/// fills in what it leaves open: order, substeps, tolerance, arithmetic, scalar.
void check_method(SceneDraft& draft, const SystemInfo& system);

/// Checks that the method of a draft, if it has one, accepts the scene: Λ, and what
/// SystemEntry::refusal says. Call it once the system has checked its own fields.
void check_method_accepts_scene(SceneDraft& draft, const SystemInfo& system);

/// Makes a scene from the description of a single motion. It adds to SceneDraft what needs the
/// catalogue: the system checks its own fields, and the method must be one of the system's.
class SceneResolver {
 public:
  /// `place` must outlive the resolver.
  SceneResolver(SceneDescription description, double largest_repair, const Place& place)
      : draft_(std::move(description), largest_repair, place), place_(place) {}
  /// Starts from a valid scene that is to get another method.
  SceneResolver(Scene scene, const Place& place) : draft_(std::move(scene), place), place_(place) {}

  /// Checks everything, and the method if there is one.
  void check();
  const Violations& violations() const { return draft_.violations(); }
  /// Returns the scene as far as `check` has filled it in.
  const Scene& scene() const { return draft_.scene(); }

  /// Checks the description and returns the scene. Refuses a continuous system without a method,
  /// with the reason METHOD_NOT_CHOSEN.
  std::expected<Scene, Violations> resolve();
  /// Checks the description of a continuous system without a method, and returns the scene with the
  /// recommended method.
  std::expected<Scene, Violations> resolve_recommending();
  /// Returns the valid scene with another method.
  std::expected<Scene, Violations> with(MethodDescription method);

 private:
  void check_tolerance_and_horizon(const SystemInfo& system);
  void check_method_if_given(const SystemInfo& system);

  SceneDraft draft_;
  const Place& place_;
};

}  // namespace stiefel
