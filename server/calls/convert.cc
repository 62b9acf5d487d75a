#include "server/calls/service.h"
#include "server/convert/answers.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {

void Convert(ServerCall& call, const v1::ConvertRequest& request, v1::ConvertResponse* response) {
  call.hold(memory_price(
      {held_by(request), 2 * scene_workspace(request.scene()), held_by(request.scene())}));
  convert(request, call.memory(), response);
}

}  // namespace stiefel::server
