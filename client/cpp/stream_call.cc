#include "stiefel/client/stream.h"

#include <algorithm>
#include <utility>

#include "client/cpp/assembly.h"
#include "client/cpp/late.h"
#include "client/cpp/replies.h"

namespace stiefel::client {

Stream::Stream(std::shared_ptr<const Connection> connection, std::string session_id, Range range,
               std::shared_ptr<Recreation> recreation)
    : connection_(std::move(connection)),
      recreation_(recreation ? std::move(recreation)
                             : std::make_shared<Recreation>(connection_, session_id)),
      deadline_(connection_->options.compute_timeout),
      every_(range.every),
      assembly_(std::make_shared<Assembly>()),
      layout_(std::make_shared<Layout>(Layout::Names(range.fields.begin(), range.fields.end()), 3,
                                       true)) {
  request_.set_session_id(std::move(session_id));
  request_.set_from(range.from);
  request_.set_to(range.to);
  request_.set_every(range.every);
  request_.mutable_fields()->Assign(range.fields.begin(), range.fields.end());
  request_.set_return_checkpoint(range.return_checkpoint);
  const std::int64_t recreation_every = recreation_->checkpoint_every();
  request_.set_checkpoint_every(range.checkpoint_every == 0 || recreation_every == 0
                                    ? std::max(range.checkpoint_every, recreation_every)
                                    : std::min(range.checkpoint_every, recreation_every));
  open();
}

Stream::~Stream() {
  if (!reader_) return;
  context_->TryCancel();
  reader_->Finish();
}

void Stream::open() {
  *assembly_ = {};
  steps_ = std::make_shared<Steps>(request_);
  answered_ = false;
  partial_checkpoint_.reset();
  cancel_.reset();
  context_ = std::make_unique<grpc::ClientContext>();
  deadline_.limit(*context_);
  recreation_->route(*context_);
  cancel_ = std::make_unique<CancelOnStop>(connection_->options.stop, *context_);
  reader_ = connection_->stub->Stream(context_.get(), request_);
}

/// Opens a stream for the rest of the request after everything up to `step` has arrived: from the
/// next sample on, or for the last sample alone if only that or its run status is missing.
void Stream::resume_after(std::int64_t step) {
  const std::int64_t every = every_ == 0 ? 1 : every_;
  request_.set_from(every > request_.to() - step ? request_.to() : step + every);
  open();
}

bool Stream::take() {
  computed_ = std::max(computed_, batch_.computed_steps());
  if (!has_price_) check_present(batch_, {"price"});
  if (!std::exchange(has_price_, true)) price_ = batch_.price();
  if (batch_.has_checkpoint()) take_checkpoint();
  const bool is_new = take_samples();
  if (batch_.has_run_status()) {
    require(!assembly_->begun(), "the last sample is incomplete");
    steps_->end(batch_.run_status(), last_step_);
    run_status_ = batch_.run_status();
  }
  return is_new;
}

bool Stream::take_samples() {
  const int size = batch_.steps_size();
  if (size == 0) return false;
  assembly_->take(batch_.mutable_fields());
  if (batch_.sample_continues()) return false;
  *batch_.mutable_fields() = assembly_->finish();
  layout_->check(batch_.fields(), size);
  steps_->check(batch_);
  // After a break between the last sample and its run status, the last sample comes once more.
  if (last_step_ && batch_.steps(0) <= *last_step_) return false;
  last_step_ = batch_.steps(size - 1);
  return true;
}

void Stream::take_checkpoint() {
  auto& part = *batch_.mutable_checkpoint();
  if (part.offset() == 0) partial_checkpoint_ = Checkpoint{.step = part.step(), .bytes = {}};
  if (!partial_checkpoint_ || part.offset() != partial_checkpoint_->bytes.size())
    throw CorruptReply("a part of the checkpoint of step " + std::to_string(part.step()) +
                       " is missing");
  partial_checkpoint_->bytes += part.data();
  require(partial_checkpoint_->bytes.size() <= part.size(), "a checkpoint is too long");
  if (partial_checkpoint_->bytes.size() == part.size())
    recreation_->keep(*(checkpoint_ = std::exchange(partial_checkpoint_, std::nullopt)));
}

/// Returns whether a failed stream may be opened again: after a pause, or after the session was
/// created again. If there is a checkpoint, the session is created again first, because a server
/// that held it long ago would compute all steps since then.
bool Stream::recovers(const grpc::Status& status, Patience& pauses, Patience& recoveries) {
  const auto created = [&] {
    return recreation_->recovers(connection_->error(status), deadline_, recoveries);
  };
  if (answered_ && recreation_->has_checkpoint() && created()) return true;
  return pauses.allows_another(status) || created();
}

const v1::StreamResponse* Stream::next_batch() {
  auto patience = connection_->patience(deadline_),
       recoveries = connection_->patience_to_recover(deadline_);
  while (reader_) {
    if (reader_->Read(&batch_)) {
      if (!std::exchange(answered_, true)) recreation_->check_build(*context_, false);
      if (take()) return &batch_;
      continue;
    }
    const grpc::Status status = finish(*context_, *std::exchange(reader_, nullptr));
    computed_before_ += std::exchange(computed_, 0);
    if (status.ok()) {
      require(run_status_.has_value(), "the stream ends without saying how the run ended");
      break;
    }
    recreation_->check_build(*context_, true);
    if (!recovers(status, patience, recoveries))
      throw with_standing(connection_->error(status, *context_), *connection_,
                          request_.session_id(), request_.to());
    if (last_step_) {
      resume_after(*last_step_);
    } else {
      open();
    }
  }
  return nullptr;
}

}  // namespace stiefel::client
