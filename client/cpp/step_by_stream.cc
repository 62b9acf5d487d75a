#include "client/cpp/step_by_stream.h"

#include "stiefel/client/stream.h"

namespace stiefel::client {
namespace {

/// Copies the last sample of a batch into `sample`.
void copy_last_sample(const v1::StreamResponse& batch, v1::Sample* sample) {
  sample->Clear();
  const int samples = batch.steps_size();
  sample->set_step(batch.steps(samples - 1));
  sample->set_time(batch.times(samples - 1));
  for (const auto& field : batch.fields()) {
    auto& copy = *sample->add_fields();
    copy.set_name(field.name());
    auto& tensor = *copy.mutable_value();
    tensor.set_data_type(field.value().data_type());
    const auto& shape = field.value().shape();
    tensor.mutable_shape()->Add(shape.begin() + 1, shape.end());
    const std::string& data = field.value().data();
    const std::size_t size = data.size() / static_cast<std::size_t>(samples);
    tensor.set_data(data.substr(data.size() - size));
  }
}

}  // namespace

bool is_too_large(const Error& error) { return error.reason() == "REPLY_TOO_LARGE"; }

v1::StepResponse step_by_stream(std::shared_ptr<const Connection> connection,
                                const v1::StepRequest& request,
                                std::shared_ptr<Recreation> recreation) {
  Stream stream(std::move(connection), request.session_id(),
                {.from = request.to(),
                 .to = request.to(),
                 .fields = {request.fields().begin(), request.fields().end()},
                 .return_checkpoint = request.return_checkpoint()},
                std::move(recreation));
  v1::StepResponse reply;
  while (const auto* batch = stream.next_batch()) copy_last_sample(*batch, reply.mutable_sample());
  if (!stream.run_status())
    throw Error(grpc::StatusCode::INTERNAL, "the stream ended without a run status");
  *reply.mutable_run_status() = *stream.run_status();
  reply.set_computed_steps(stream.computed_steps());
  if (request.return_checkpoint() && stream.checkpoint())
    reply.set_checkpoint(stream.checkpoint()->bytes);
  *reply.mutable_price() = stream.price();
  return reply;
}

}  // namespace stiefel::client
