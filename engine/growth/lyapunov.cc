#include "stiefel/lyapunov.h"

#include <algorithm>
#include <utility>

#include "engine/growth/confirmation.h"
#include "engine/growth/coordinates.h"
#include "engine/growth/lyapunov_run.h"
#include "engine/growth/tangent_of.h"
#include "stiefel/price.h"

namespace stiefel {

LyapunovExponents::Made LyapunovExponents::make(const Scene& scene, const LyapunovDescription& what,
                                                const Simulation& start, const Place& place) {
  auto run = std::make_unique<LyapunovRun>(scene, what);
  Violations violations = run->prepare(start, place);
  if (violations.empty()) violations = run->begin(start, place);
  if (!violations.empty()) return std::unexpected(std::move(violations));
  return run;
}

std::int64_t LyapunovExponents::saved_step(std::string_view saved) {
  ByteReader in(saved);
  const LyapunovHeader header = LyapunovHeader::read(in);
  return in.sound() && header.is == LyapunovHeader::format ? header.step : -1;
}

LyapunovExponents::Made LyapunovExponents::resume(const Scene& scene,
                                                  const LyapunovDescription& what,
                                                  std::string_view saved, const Simulation& now,
                                                  const Place& place) {
  ByteReader in(saved);
  const LyapunovHeader header = LyapunovHeader::read(in), asked = LyapunovHeader::of(what);
  const bool fits = in.sound() && header.is == LyapunovHeader::format &&
                    header.step == now.step() && header.step >= what.from &&
                    header.step <= what.to && header.interval >= 1 && header.from == asked.from &&
                    header.count == asked.count && header.asked_interval == asked.asked_interval &&
                    header.seed == asked.seed;
  auto run = std::make_unique<LyapunovRun>(scene, what);
  if (Violations violations = fits ? run->prepare(now, place, header) : Violations();
      !violations.empty())
    return std::unexpected(std::move(violations));
  if (fits && run->restore(in, now)) return run;
  return std::unexpected(Violations{place.violation(
      "checkpoint", std::to_string(saved.size()) + " bytes",
      "must come from a LyapunovExponents of the same request, whose `to` and `every` alone may "
      "differ, and not be beyond `to`")});
}

std::uint64_t lyapunov_bytes(const Scene& scene, const LyapunovDescription& what,
                             std::int64_t size) {
  if (!tangents_of(scene.system())) return 0;
  const StateExtent x = extent_of(scene);
  const std::int64_t vectors =
      std::min({what.count > 0 ? std::max(what.count, LyapunovRun::least_vectors) : size, size,
                static_cast<std::int64_t>(x.dimension)});
  const auto m = static_cast<std::uint64_t>(vectors), D = static_cast<std::uint64_t>(size);
  const std::uint64_t squares = x.is_body || size > Linearization::largest_in_coordinates ? 0 : 3;
  // The state of the second motion is saved twice.
  const Scene map = confirming_scene(scene);
  const auto beside = std::min<std::uint64_t>(m, LyapunovRun::least_vectors);
  return linearization_bytes(scene, vectors, false) +
         linearization_bytes(map, static_cast<std::int64_t>(beside), false) +
         2 * simulation_bytes(scene) + 3 * simulation_bytes(map) +
         sizeof(double) *
             (6 * D * (m + beside) + squares * D * D + 256 * (m + beside + 16) + 8 * m * m);
}

}  // namespace stiefel
