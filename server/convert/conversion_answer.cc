#include "server/convert/answers.h"

#include <algorithm>

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/memory_price.h"
#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/stop.h"
#include "stiefel/tradeoff.h"

namespace stiefel::server {

namespace {

/// Returns the most operations that a conversion may take. The inverse of J_D outside its domain
/// takes the most, 8·10⁴ N³, because it looks for the edge.
double most_work(const Scene& scene) {
  const double N = whole_dimension(scene);
  return 1e5 * N * N * N + 1e6;
}

}  // namespace

StatusError refused(const ConversionRefusal& refusal) {
  if (const auto* violations = std::get_if<Violations>(&refusal))
    return errors::invalid(*violations);
  return errors::outside_domain(std::get<OutsideDomain>(refusal));
}

void ConversionAnswer::convert(v1::ConvertResponse& response) {
  const v1::Scene& given = request_.scene();
  const auto resolved = read_scene(request_.has_scene(), given, "scene", [&] {
    memory_.grow_to(memory_.bytes() + choice_workspace(given));
  });
  memory_.grow_to(memory_.bytes() + conversion_workspace(given));
  const Scene& scene = resolved.scene;
  const Resolution& resolution = resolved.resolution;
  ConversionTarget target{request_.to()};
  if (request_.has_epsilon()) target.epsilon = request_.epsilon();
  if (request_.has_parameter()) target.parameter = request_.parameter();
  const std::stop_token never;
  const StopScope cap(never, most_work(scene));
  const auto converted = [&] {
    try {
      return stiefel::convert(scene, target);
    } catch (const Stopped&) {
      if (!cap.used_up()) throw;
      return std::expected<Conversion, ConversionRefusal>(std::unexpected(Violations{
          {"to", target.name, "takes more than " + to_text(most_work(scene)) + " operations"}}));
    }
  }();
  if (!converted) throw refused(converted.error());
  if (converted->scene) {
    const SceneDescription& result = converted->scene->description();
    const Difference changes = difference(from_proto(given), result);
    const auto left_out = write_view(result, changes, request_.view(), response.mutable_scene());
    if (request_.view() == v1::SCENE_VIEW_NONE) response.clear_scene();
    if (request_.view() != v1::SCENE_VIEW_FULL && request_.view() != v1::SCENE_VIEW_NONE)
      for (const std::string& field : changes.cleared) response.add_cleared(field);
    for (const SceneArray& array : arrays_of(result))
      if (std::ranges::find(left_out, array.path) != left_out.end())
        scene_arrays_.add(to_field(array));
  }
  for (const auto& [name, block] : converted->blocks) {
    const RowMatrix rows = block;
    blocks_.add(to_field({name, rows.rows(), rows.cols(), rows.data(), nullptr}));
  }

  for (const auto& [domain, margin] : converted->margins) {
    auto* to = response.add_margins();
    to->set_domain(domain);
    to->set_margin(margin);
  }
  if (resolution.choice) to_proto(scene, *resolution.choice, response.mutable_choice());
}

void ConversionAnswer::next(v1::ConvertResponse& response) {
  response.Clear();
  if (!started_) convert(response);
  // Other arrays wait for the next message, since those in the scene may fill the first one.
  const bool room = started_ || scene_arrays_.empty();
  started_ = true;
  if (room && !scene_arrays_.empty())
    scene_arrays_.take(part_bytes, response.mutable_scene_arrays());
  else if (room && !blocks_.empty())
    blocks_.take(part_bytes, response.mutable_blocks());
  response.set_continues(!done());
}

}  // namespace stiefel::server
