#include <google/protobuf/util/time_util.h>

#include "server/convert/convert.h"
#include "server/convert/price.h"
#include "server/convert/scene_view.h"
#include "server/sessions/field_bytes.h"
#include "server/sessions/numerics_id.h"
#include "stiefel/stop.h"

namespace stiefel::server {
namespace {

google::protobuf::Timestamp timestamp(std::chrono::system_clock::time_point time) {
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  return google::protobuf::util::TimeUtil::NanosecondsToTimestamp(since.count());
}

void write_heading(const Session& session, const Registry& registry, v1::Session* out) {
  out->set_session_id(session.id());
  out->set_system(session.scene().system());
  out->set_numerics_id(numerics_id());
  out->set_cursor(session.cursor());
  *out->mutable_create_time() = timestamp(session.create_time());
  *out->mutable_expire_time() = timestamp(registry.expire_time(session));
}

void write_scene(const Session& session, const Resolution& resolution, v1::SceneView view,
                 v1::Session* out) {
  const SceneDescription& resolved = session.scene().description();
  for (std::string& path : write_view(resolved, resolution.difference, view, out->mutable_scene()))
    out->add_left_out(std::move(path));
  if (view == v1::SCENE_VIEW_NONE) out->clear_scene();
  if (view != v1::SCENE_VIEW_FULL && view != v1::SCENE_VIEW_NONE)
    for (const std::string& field : resolution.difference.cleared) out->add_cleared(field);
  if (resolution.choice) to_proto(session.scene(), *resolution.choice, out->mutable_choice());
}

}  // namespace

void to_proto(const Scene& scene, const ChosenMethod& choice, v1::Choice* out) {
  to_proto(*scene.description().method, out->mutable_method());
  out->set_tolerance(choice.tolerance);
  out->set_horizon(choice.horizon);
  out->set_reason(choice.reason);
  out->set_error(choice.error);
  out->set_verified(choice.verified);
}

void to_proto(const Session& session, const Resolution& resolution, const Registry& registry,
              const v1::SessionView& view, v1::Session* out) {
  write_heading(session, registry, out);
  write_scene(session, resolution, view.scene(), out);
  const auto steps = session.cached_steps();
  out->mutable_cached_steps()->Add(steps.begin(), steps.end());
  for (const std::string& warning : session.warnings()) out->add_warnings(warning);
  to_proto(session.work(0, 1), sample_bytes(session, session.default_fields()),
           v1::PRICE_BOUND_EXPECTED, session.simulation_bytes(), out->mutable_step_price());
}

bool shows_scenes(const v1::SessionView& view) {
  return view.scene() != v1::SCENE_VIEW_UNSPECIFIED && view.scene() != v1::SCENE_VIEW_NONE;
}

void to_list(const Session& session, const Registry& registry, const v1::SessionView& view,
             v1::Session* out) {
  stop_point();
  if (shows_scenes(view)) return to_proto(session, session.resolution(), registry, view, out);
  write_heading(session, registry, out);
}

}  // namespace stiefel::server
