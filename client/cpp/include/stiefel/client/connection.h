#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "stiefel/client/error.h"
#include "stiefel/client/recreation.h"
#include "stiefel/client/refusals.h"
#include "stiefel/client/security.h"
#include "stiefel/client/unreachable.h"
#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::client {

struct Options {
  /// Deadline of calls that do not run simulations.
  std::chrono::milliseconds timeout = std::chrono::seconds(30);
  /// Deadline of calls that run simulations: Step, Diagnose, ForkSession, Connect, MeasureTradeoff,
  /// Summarize, and a whole Stream with its resumptions and pauses. None by default, because only
  /// the caller knows the length of a run.
  std::optional<std::chrono::milliseconds> compute_timeout = std::nullopt;
  /// How long a call is repeated while the server is UNAVAILABLE, or ends calls because of too much
  /// at once. Repeating is safe because every call is idempotent.
  std::chrono::milliseconds patience = std::chrono::seconds(2);
  /// Whether a session may go on at a server of another build, whose states may have other bits. If
  /// false, a call that such a server answers throws BuildChanged.
  bool any_build = false;
  /// A stop request cancels all running and later calls except the deletion of a session; the
  /// cancelled calls throw Error.
  std::stop_token stop = {};
  /// TLS and token of the channel that `Client::connect` makes.
  Security security = {};
};

/// Cancels the call of a context when a stop is requested. The context must outlive this object.
class CancelOnStop {
 public:
  CancelOnStop(const std::stop_token& stop, grpc::ClientContext& context)
      : callback_(stop, Cancel{&context}) {}

 private:
  struct Cancel {
    grpc::ClientContext* context;
    void operator()() const { context->TryCancel(); }
  };
  std::stop_callback<Cancel> callback_;
};

/// The deadline of a call including its repetitions, on the monotonic clock.
class Deadline {
 public:
  using Timeout = std::optional<std::chrono::milliseconds>;

  explicit Deadline(Timeout timeout)
      : end_(timeout ? std::optional(std::chrono::steady_clock::now() + *timeout) : std::nullopt) {}

  /// Sets the deadline of one attempt to the time that is left.
  void limit(grpc::ClientContext& context) const {
    if (end_) context.set_deadline(std::chrono::system_clock::now() + left());
  }
  /// Returns the pause, or the time that is left if that is shorter.
  std::chrono::milliseconds at_most(std::chrono::milliseconds pause) const {
    return end_ ? std::min(pause, std::chrono::ceil<std::chrono::milliseconds>(left())) : pause;
  }

 private:
  std::chrono::steady_clock::duration left() const {
    return std::max(*end_ - std::chrono::steady_clock::now(),
                    std::chrono::steady_clock::duration::zero());
  }

  std::optional<std::chrono::steady_clock::time_point> end_;
};

/// Decides whether a failed call is tried again, and pauses before the next attempt. Each call, and
/// each batch of a stream, has a Patience of its own.
class Patience {
 public:
  /// `channel`: a pause ends early when this channel has connected; null if there is nothing to
  /// connect. `limit`: the sum of all pauses. No pause goes beyond the deadline; the attempt after
  /// it then fails with DEADLINE_EXCEEDED.
  Patience(grpc::Channel* channel, std::chrono::milliseconds limit,
           Deadline deadline = Deadline(std::nullopt), std::stop_token stop = {})
      : channel_(channel), limit_(limit), deadline_(deadline), stop_(std::move(stop)) {}

  /// Pauses and returns true if the call may be tried again. Returns false at once if the status is
  /// neither UNAVAILABLE nor `is_too_much_at_once` or the pauses are used up, and false when a stop
  /// is requested. After a refusal that says when to come back, the pause is that of refusals.h; if
  /// it would end after the deadline, returns false at once.
  bool allows_another(const grpc::Status& status) {
    if (const auto pause = refusals_.next(status)) return allows_pause(*pause);
    const bool may_pass = as_unavailable(status).error_code() == grpc::StatusCode::UNAVAILABLE ||
                          is_too_much_at_once(status);
    if (!may_pass || total_pause_ >= limit_) return false;
    const auto until = std::chrono::system_clock::now() + deadline_.at_most(pause_);
    if (channel_ && channel_->GetState(true) != GRPC_CHANNEL_READY) {
      // gRPC connects only while a thread waits inside it, so this thread must not sleep outside.
      channel_->WaitForConnected(until);
    } else {
      sleep_until(until);
    }
    total_pause_ += pause_;
    pause_ = std::min(2 * pause_, std::chrono::milliseconds(400));
    return !stop_.stop_requested();
  }

 private:
  bool allows_pause(std::chrono::milliseconds pause) {
    if (deadline_.at_most(pause) < pause) return false;
    sleep_until(std::chrono::system_clock::now() + pause);
    return !stop_.stop_requested();
  }
  void sleep_until(std::chrono::system_clock::time_point until) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait_until(lock, stop_, until, [] { return false; });
  }

  Refusals refusals_;
  grpc::Channel* channel_;
  std::chrono::milliseconds limit_;
  Deadline deadline_;
  std::stop_token stop_;
  std::chrono::milliseconds total_pause_{0};
  std::chrono::milliseconds pause_{25};
};

/// Returns the status of a stream whose Read has returned false. Throws CorruptReply if that was
/// not the end but a message that cannot be parsed: gRPC says the same for both, and its Finish
/// would wait until every message was read.
template <class Reply>
grpc::Status finish(grpc::ClientContext& context, grpc::ClientReader<Reply>& reader) {
  constexpr int unreadable = 16;  // messages in a row
  Reply next;
  for (int i = 0; i < unreadable; ++i) {
    if (!reader.Read(&next)) continue;
    context.TryCancel();
    reader.Finish();
    throw CorruptReply("a message of the stream cannot be parsed");
  }
  return reader.Finish();
}

/// The connection that a Client and its Sessions share.
struct Connection {
  std::unique_ptr<v1::SimulationService::Stub> stub;
  Options options;
  /// Null if the caller made the channel: an in-process channel cannot be asked for its state.
  std::shared_ptr<grpc::Channel> channel = nullptr;
  /// The address of the channel; empty if the caller made the channel.
  std::string address = {};

  Patience patience(Deadline deadline) const {
    return {channel.get(), options.patience, deadline, options.stop};
  }

  /// Returns the patience for recreating a session within one call. It is ten times that of a call,
  /// because servers may be lost one after the other and each recreation is progress.
  Patience patience_to_recover(Deadline deadline) const {
    return {nullptr, 10 * options.patience, deadline, options.stop};
  }

  /// Returns the error of a failed call, in plain words if the server cannot be reached. Throws
  /// CorruptReply for a reply that cannot be read. `context` is that of the call.
  Error error(const grpc::Status& status, const grpc::ClientContext& context) const {
    return Error(with_price(plain(status), context));
  }
  Error error(const grpc::Status& status) const { return Error(plain(status)); }
  grpc::Status plain(const grpc::Status& status) const {
    if (is_unreadable(status)) throw CorruptReply("the reply is no message of this call");
    const bool connected = !channel || channel->GetState(false) == GRPC_CHANNEL_READY;
    const bool stopped = options.stop.stop_requested();
    return in_plain_words(stopped ? status : as_unavailable(status), address, connected,
                          options.security.tls.has_value());
  }

  using Stub = v1::SimulationService::Stub;
  template <class Request, class Reply>
  using Method = grpc::Status (Stub::*)(grpc::ClientContext*, const Request&, Reply*);
  template <class Request, class Reply>
  using StreamingMethod = std::unique_ptr<grpc::ClientReader<Reply>> (Stub::*)(grpc::ClientContext*,
                                                                               const Request&);

  /// Makes a unary call and returns its reply. Repeats the call while the server is UNAVAILABLE
  /// and, with a `session`, after creating a lost session again. Throws Error.
  template <class Request, class Reply>
  Reply call(Method<Request, Reply> method, const Request& request,
             std::optional<std::chrono::milliseconds> timeout,
             Recreation* session = nullptr) const {
    const Deadline deadline(timeout);
    auto recoveries = patience_to_recover(deadline);
    for (auto waiting = patience(deadline);;) {
      grpc::ClientContext context;
      deadline.limit(context);
      const CancelOnStop cancel(options.stop, context);
      if (session) session->route(context);
      Reply reply;
      const grpc::Status status = (stub.get()->*method)(&context, request, &reply);
      if (session) session->check_build(context, !status.ok());
      if (status.ok()) return reply;
      if (waiting.allows_another(status)) continue;
      if (!session || !session->recovers(error(status), deadline, recoveries))
        throw error(status, context);
    }
  }

  /// Makes a call with a stream of replies and returns all of them, at least one. Repeats the whole
  /// call while the server is UNAVAILABLE. Throws Error.
  template <class Request, class Reply>
  std::vector<Reply> call_all(StreamingMethod<Request, Reply> method, const Request& request,
                              std::optional<std::chrono::milliseconds> timeout) const {
    const Deadline deadline(timeout);
    for (auto waiting = patience(deadline);;) {
      grpc::ClientContext context;
      deadline.limit(context);
      const CancelOnStop cancel(options.stop, context);
      const auto reader = (stub.get()->*method)(&context, request);
      std::vector<Reply> replies;
      for (Reply reply; reader->Read(&reply);) replies.push_back(std::move(reply));
      const grpc::Status status = finish(context, *reader);
      if (status.ok() && !replies.empty()) return replies;
      if (status.ok()) throw CorruptReply("the server ended the call without a reply");
      if (!waiting.allows_another(status)) throw error(status, context);
    }
  }
};

}  // namespace stiefel::client
