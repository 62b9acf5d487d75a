#include "server/convert/answers.h"

#include "engine/numbers/to_text.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"
#include "server/sessions/field_bytes.h"
#include "stiefel/stop.h"

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

void convert(const v1::ConvertRequest& request, MemoryLease& memory,
             v1::ConvertResponse* response) {
  const auto [scene, choice, place] =
      read_scene(request.has_scene(), request.scene(), "scene",
                 [&](std::uint64_t bytes) { memory.grow_to(memory.bytes() + bytes); });
  memory.grow_to(memory.bytes() + conversion_workspace(scene));
  ConversionTarget target{request.to()};
  if (request.has_epsilon()) target.epsilon = request.epsilon();
  if (request.has_parameter()) target.parameter = request.parameter();
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
  if (converted->scene && request.return_scene())
    to_proto(converted->scene->description(), response->mutable_scene());
  for (const auto& [name, block] : converted->blocks)
    *response->add_blocks() = to_field(name, block);
  for (const auto& [domain, margin] : converted->margins) {
    auto* to = response->add_margins();
    to->set_domain(domain);
    to->set_margin(margin);
  }
  if (choice) to_proto(*choice, response->mutable_choice());
}

}  // namespace stiefel::server
