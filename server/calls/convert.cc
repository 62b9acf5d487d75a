#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/conversion.h"
#include "server/convert/memory_price.h"
#include "server/convert/resolve.h"

namespace stiefel::server {
namespace {

// Above it, a conversion is more than a slice of work.
constexpr int small_dimension = 64;

}  // namespace

grpc::ServerWriteReactor<v1::ConvertResponse>* Service::Convert(Context* context,
                                                                const v1::ConvertRequest* request) {
  const auto answer = std::make_shared<ConversionAnswer>(*request);
  const auto memory = std::make_shared<MemoryLease>();
  const v1::Scene& scene = request->scene();
  const bool long_work = wants_choice(scene) || scene.inertia_size() > small_dimension;
  Pool& pool = long_work ? host_.searches : host_.pool;
  return new SlicedStream<v1::ConvertResponse>(
      host_, pool, open(context, "Convert"),
      [this, answer, memory, request](const std::stop_token&, v1::ConvertResponse& response)
          -> std::expected<bool, grpc::Status> {
        if (!*memory) *memory = MemoryLease(host_.memory, conversion_memory(request->scene()));
        if (const auto status = answer->next(response); !status.ok())
          return std::unexpected(status);
        return answer->done();
      });
}

}  // namespace stiefel::server
