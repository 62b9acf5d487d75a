#include <cmath>

#include "engine/simulation/catalogue.h"
#include "engine/simulation/reference.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/step_weight.h"

namespace stiefel {
namespace {

/// The scene by the engine's own best method, twice: the distance is the error of both.
class RefinedReference final : public Reference {
 public:
  RefinedReference(Scene fine, Scene coarse, std::string description, double budget)
      : fine_scene_(std::move(fine)),
        coarse_scene_(std::move(coarse)),
        fine_(make_simulation(fine_scene_)),
        coarse_(make_simulation(coarse_scene_)),
        weight_(step_weight(fine_scene_)),
        description_(std::move(description)),
        budget_(budget) {}

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    const auto step = static_cast<std::int64_t>(std::llround(time / fine_scene_.step()));
    for (Simulation* now : {fine_.get(), coarse_.get()})
      while (now->step() < step)
        if (stop.stop_requested() || work() > budget_ || !now->advance(1).reached())
          return std::nullopt;
    MotionState state = read_motion(fine_scene_, *fine_);
    const double error = error_of(read_motion(coarse_scene_, *coarse_), state).largest();
    error_ = std::max({error_, error, 0x1p-52});
    return Answer{std::move(state), error_};
  }

  std::string description() const override { return description_; }
  double work() const override {
    return weight_ * static_cast<double>(fine_->map_steps() + coarse_->map_steps());
  }

 private:
  Scene fine_scene_, coarse_scene_;
  std::unique_ptr<Simulation> fine_, coarse_;
  double weight_;
  std::string description_;
  double budget_, error_ = 0;
};

Scene with(const Scene& scene, MethodDescription method) {
  SceneDescription description = scene.description();
  description.method = std::move(method);
  return Scene::resolve(std::move(description)).value();
}

}  // namespace

std::unique_ptr<Reference> make_refined_reference(const Scene& scene, const ReferenceNeed& need) {
  constexpr double finest_tolerance = 1e-13;  // what double precision can meet
  const auto by = [&](double tolerance) {
    return with(scene, {"adaptive", {}, {}, "compensated", tolerance});
  };
  return std::make_unique<RefinedReference>(by(finest_tolerance), by(10 * finest_tolerance),
                                            "adaptive with tolerance 1e-13 in double precision",
                                            need.budget);
}

}  // namespace stiefel
