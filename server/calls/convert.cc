#include "server/calls/limits.h"
#include "server/calls/service.h"
#include "server/calls/sliced_stream.h"
#include "server/convert/conversion.h"
#include "server/convert/pricing/request_memory.h"
#include "server/convert/resolve.h"

namespace stiefel::server {
namespace {

/// The conversion of a larger scene is more than a slice of work.
constexpr int small_dimension = 64;

}  // namespace

grpc::ServerWriteReactor<v1::ConvertResponse>* Service::Convert(Context* context,
                                                                const v1::ConvertRequest* request) {
  CallLog log = open(context, "Convert");
  try {
    const auto memory =
        std::make_shared<const MemoryLease>(log.account().memory(), conversion_memory(*request));
    const auto answer = std::make_shared<ConversionAnswer>(*request);
    const v1::Scene& scene = request->scene();
    const bool long_work = wants_choice(scene) || scene.inertia_size() > small_dimension ||
                           scene.members() > few_members;
    Pool& pool = long_work ? host_.searches : host_.pool;
    return message_a_slice<v1::ConvertResponse>(
        host_, pool, std::move(log), 0,
        [memory, answer](const std::stop_token&,
                         v1::ConvertResponse& response) -> std::expected<bool, grpc::Status> {
          if (const auto status = answer->next(response); !status.ok())
            return std::unexpected(status);
          return answer->done();
        });
  } catch (...) {
    return new RefusedStream<v1::ConvertResponse>(log, errors::from_current_exception());
  }
}

}  // namespace stiefel::server
