#pragma once

#include <limits>
#include <optional>

#include "engine/motion/method_entry.h"
#include "engine/motion/resolve.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/given_body.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

/// The members of an ensemble whose description has a `body`, as numbers: each is checked like a
/// scene of its own (Scene::resolve), in a fifth of the instructions.
class GivenMembers {
 public:
  /// `first` is the first member, which decides what the members have in common; `ensemble` must
  /// outlive this object. Repairs like Scene::resolve, members that were checked without a limit.
  GivenMembers(const SceneDescription& ensemble, const Scene& first,
               double largest_repair = std::numeric_limits<double>::max())
      : ensemble_(ensemble),
        draft_(first, largest_repair),
        check_(system_entry(first.system())->body_of),
        method_(method_entry(first.method())) {}

  /// Whether the members are given so.
  bool any() const { return ensemble_.members && ensemble_.body && check_; }

  GivenBody given(std::size_t b) const {
    GivenBody body(*ensemble_.body, b, static_cast<std::size_t>(*ensemble_.members));
    if (body.attitude.empty()) body.attitude = upright;
    return body;
  }
  /// Returns member b; nullopt where a check finds a violation.
  std::optional<Body3> operator[](std::size_t b) {
    auto body = check_(draft_, given(b));
    draft_.forget_violations();
    if (body && !accepts_body(method_, *body, draft_.step())) body.reset();
    return body;
  }

 private:
  static constexpr double upright[] = {1, 0, 0, 0};

  const SceneDescription& ensemble_;
  SceneDraft draft_;
  std::optional<Body3> (*check_)(SceneDraft&, const GivenBody&);
  const MethodEntry* method_;
};

}  // namespace stiefel
