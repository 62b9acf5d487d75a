#include "server/calls/cursor_call.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/errors.h"
#include "server/convert/requests.h"
#include "stiefel/conversion.h"

namespace stiefel::server {

grpc::Status refused(const ConversionRefusal& refusal) {
  if (const auto* violations = std::get_if<Violations>(&refusal))
    return errors::invalid(*violations);
  return errors::outside_domain(std::get<OutsideDomain>(refusal));
}

namespace {

grpc::Status convert_scene(const v1::ConvertRequest& request, v1::ConvertResponse* response) {
  const auto scene = read_scene(request.has_scene(), request.scene());
  if (!scene) return scene.error();
  ConversionTarget target{request.to()};
  if (request.has_epsilon()) target.epsilon = request.epsilon();
  if (request.has_parameter()) target.parameter = request.parameter();
  const auto converted = convert(*scene, target);
  if (!converted) return refused(converted.error());
  if (converted->scene) to_proto(converted->scene->description(), response->mutable_scene());
  for (const auto& [name, block] : converted->blocks)
    to_proto(RowMatrix(block), &(*response->mutable_blocks())[name]);
  for (const auto& [domain, margin] : converted->margins) {
    auto* to = response->add_margins();
    to->set_domain(domain);
    to->set_margin(margin);
  }
  return grpc::Status::OK;
}

}  // namespace

grpc::ServerUnaryReactor* Service::Convert(Context* context, const v1::ConvertRequest* request,
                                           v1::ConvertResponse* response) {
  Pool& pool = wants_choice(request->scene()) ? host_.searches : host_.pool;
  return new PooledCall(host_, pool, CallLog(host_.log, *context, "Convert"),
                        [this, request, response](const std::stop_token&) {
                          if (host_.lifecycle.refusing()) return errors::shutting_down();
                          return convert_scene(*request, response);
                        });
}

}  // namespace stiefel::server
