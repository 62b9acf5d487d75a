#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/conversion.h"
#include "server/convert/resolve.h"

namespace stiefel::server {

grpc::ServerWriteReactor<v1::ConvertResponse>* Service::Convert(Context* context,
                                                                const v1::ConvertRequest* request) {
  const auto answer = std::make_shared<ConversionAnswer>(*request);
  Pool& pool = wants_choice(request->scene()) ? host_.searches : host_.pool;
  return new SlicedStream<v1::ConvertResponse>(
      host_, pool, open(context, "Convert"),
      [answer](const std::stop_token&,
               v1::ConvertResponse& response) -> std::expected<bool, grpc::Status> {
        if (const auto status = answer->next(response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
