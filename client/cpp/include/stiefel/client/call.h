#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <functional>
#include <iterator>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "stiefel/client/error.h"
#include "stiefel/client/options.h"
#include "stiefel/v1/simulation.grpc.pb.h"

namespace stiefel::client {

/// The protocol's calls: `&Stub::Describe`, `&Stub::Summarize`, ...
using Stub = v1::SimulationService::Stub;

/// A call with one reply.
template <class Request, class Reply>
using Unary = grpc::Status (Stub::*)(grpc::ClientContext*, const Request&, Reply*);
/// A call with a stream of replies.
template <class Request, class Reply>
using Streaming = std::unique_ptr<grpc::ClientReader<Reply>> (Stub::*)(grpc::ClientContext*,
                                                                       const Request&);

/// The connection that a Client and its Sessions share.
struct Connection {
  std::unique_ptr<Stub> stub;
  Options options;
  std::string address = {};  ///< empty if the caller made the channel

  /// Returns the error of a failed call, which names the address of a server that does not answer.
  Error error(const grpc::Status& status) const;
};

/// What gRPC needs for one call: its deadline, and the session's id for proxies that choose the
/// server by it. A stop request of the connection cancels the call.
class Context {
 public:
  Context(const Connection& connection, const std::string& session_id, bool has_timeout = true);

  grpc::ClientContext* get() { return &context_; }
  void cancel() { context_.TryCancel(); }

 private:
  grpc::ClientContext context_;
  std::stop_callback<std::function<void()>> stop_;
};

/// Returns the id of the session that a request names; empty if it names none.
template <class Request>
std::string session_of(const Request& request) {
  if constexpr (requires { request.from_session_id(); })
    return request.from_session_id();
  else if constexpr (requires { request.session_id(); })
    return request.session_id();
  else
    return {};
}

/// The replies of a call, as an input range:
///
///     for (const auto& part : client.call(&Stub::MeasureTradeoff, request)) ...
///
/// or one by one with `next`. Destruction cancels the call. Not thread-safe, but any thread may
/// cancel it.
template <class Reply>
class Replies {
 public:
  template <class Request>
  Replies(std::shared_ptr<const Connection> connection, Streaming<Request, Reply> method,
          const Request& request)
      : connection_(std::move(connection)),
        context_(std::make_unique<Context>(*connection_, session_of(request))),
        reader_((connection_->stub.get()->*method)(context_->get(), request)) {}
  ~Replies() {
    if (!reader_) return;
    cancel();
    reader_->Finish();
  }
  Replies(Replies&&) noexcept = default;
  /// Deleted because it would abandon the assigned-to call without cancelling it.
  Replies& operator=(Replies&&) = delete;

  /// Returns the next reply, null at the end. It is the caller's until the next call. Throws Error.
  Reply* next() {
    if (!reader_) return nullptr;
    if (reader_->Read(&reply_)) return &reply_;
    const grpc::Status status = std::exchange(reader_, nullptr)->Finish();
    if (!status.ok()) throw connection_->error(status);
    return nullptr;
  }
  /// The next reply then throws Error with the code CANCELLED.
  void cancel() { context_->cancel(); }

  class Iterator {
   public:
    using iterator_concept = std::input_iterator_tag;
    using value_type = Reply;
    using difference_type = std::ptrdiff_t;

    explicit Iterator(Replies& replies) : replies_(&replies), reply_(replies.next()) {}
    Reply& operator*() const { return *reply_; }
    Reply* operator->() const { return reply_; }
    Iterator& operator++() {
      reply_ = replies_->next();
      return *this;
    }
    void operator++(int) { ++*this; }
    bool operator==(std::default_sentinel_t) const { return reply_ == nullptr; }

   private:
    Replies* replies_;
    Reply* reply_;
  };

  /// May be called only once, because the replies are an input range.
  Iterator begin() { return Iterator(*this); }
  std::default_sentinel_t end() const { return {}; }

 private:
  std::shared_ptr<const Connection> connection_;
  std::unique_ptr<Context> context_;
  std::unique_ptr<grpc::ClientReader<Reply>> reader_;
  Reply reply_;
};

/// Makes a call and returns its reply. Throws Error.
template <class Request, class Reply>
Reply call(const std::shared_ptr<const Connection>& connection, Unary<Request, Reply> method,
           const Request& request) {
  Context context(*connection, session_of(request));
  Reply reply;
  const grpc::Status status = (connection->stub.get()->*method)(context.get(), request, &reply);
  if (!status.ok()) throw connection->error(status);
  return reply;
}
/// Begins a call and returns its replies.
template <class Request, class Reply>
Replies<Reply> call(const std::shared_ptr<const Connection>& connection,
                    Streaming<Request, Reply> method, const Request& request) {
  return {connection, method, request};
}

}  // namespace stiefel::client
