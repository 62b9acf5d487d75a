#pragma once

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string_view>
#include <thread>

#include "server/calls/call_log.h"
#include "server/calls/host.h"
#include "server/calls/read_request.h"
#include "server/connections/callers.h"
#include "server/convert/errors.h"
#include "server/scheduling/turns.h"
#include "server/sessions/cursor.h"
#include "server/sessions/pending_write.h"

namespace stiefel::server {

/// The wait of an answer whose messages all have results.
inline constexpr std::chrono::milliseconds until_results = std::chrono::hours(24 * 365);

/// Sends the messages of an answer, and lets it `advance` by `slice` steps at a time while it has
/// no results, by fewer once so many have taken longer than a turn. A message without results,
/// which tells the progress, follows the one before by `longest_wait`. At a stop, `answer.save`
/// makes what may still be sent, knowing whether the stop has interrupted a piece of work.
template <class Response, class Call, class Writer, class Answer, class Advance>
void send_results(Call& call, Writer& writer, Answer& answer,
                  std::chrono::milliseconds longest_wait, double slice, const Advance& advance) {
  Response message;
  const auto send = [&] {
    const bool last = answer.next(message);
    message.set_work(call.work());
    call.write(writer, message, last);
    return last;
  };
  try {
    for (bool last = false; !last;) {
      const auto due = std::chrono::steady_clock::now() + longest_wait;
      while (!answer.has_results() && std::chrono::steady_clock::now() < due) {
        call.pass();
        const double before = call.work();
        advance(slice);
        const double took = (call.work() - before) / instructions_a_nanosecond;
        if (took > 2 * long_slice)
          slice = std::max(slice * long_slice / took, std::min(slice, 1.0));
      }
      last = send();
    }
  } catch (const Stopped&) {
    if (call.caller_left() || !answer.save(call.stop().stop_requested())) throw;
    do send();
    while (answer.has_results());
    throw;
  }
}

/// A call while its handler runs, on a thread of its own: who makes it and pays for it, its log,
/// its turn, its stop.
class ServerCall {
 public:
  ServerCall(Host& host, grpc::ServerContext& context, const char* name);
  ~ServerCall();
  ServerCall(const ServerCall&) = delete;
  ServerCall& operator=(const ServerCall&) = delete;

  /// Finds out who calls. Throws StatusError if the caller is not let in or has too many calls.
  void admit(Callers* callers);
  /// Reads a request, a long one in the call's turn, and frees the bytes. The message lives until
  /// the next one is read or `drop_request`. Throws StatusError if the bytes are no such message.
  template <class Request>
  const Request& read(grpc::ByteBuffer& bytes) {
    const auto& request = static_cast<const Request&>(read(bytes, Request::default_instance()));
    if constexpr (requires { request.session_id(); })
      if (!request.session_id().empty()) log_->name(request.session_id());
    return request;
  }
  void drop_request() { request_.drop(); }
  /// Returns the session; see find_session.
  SessionRef session(std::string_view id, const char* field = "session_id");
  /// Takes so many more bytes until the reply is sent.
  void hold(std::uint64_t bytes) {
    if (memory_)
      memory_.grow_to(memory_.bytes() + bytes);
    else
      memory_ = MemoryLease(account().memory(), bytes);
  }
  MemoryLease& memory() { return memory_; }

  /// Runs a part of the handler, which may compute: its stop points pass the call's turn.
  template <class Work>
  void run(const Work& work) {
    stop_source_ = {};  // what stopped a request of a Drive does not stop the next
    stop_ = stop_source_.get_token();
    const std::stop_callback shutdown(host_.lifecycle.stop_token(),
                                      [this] { stop_source_.request_stop(); });
    turn_->begin();
    const StopScope scope(stop_, *turn_);
    Helpers::OfCall helpers(host_.helpers, *turn_);
    const CrewOfThisThread crew(helpers);
    const Computed computed(*this);
    work();
  }
  /// Passes the turn between two pieces of work. Throws Stopped if the call is to end before its
  /// next piece.
  void pass() const {
    stop_point();
    if (host_.lifecycle.stopping() || turn_->time_is_up()) throw Stopped();
  }
  /// Calls `wait`, which waits for other calls, without a place to compute in.
  template <class Wait>
  auto without_place(const Wait& wait) {
    return turn_->without_place(wait);
  }
  /// Waits until a change is on disk, and throws StatusError if it cannot be written. Does nothing
  /// without a change.
  void wait_for(const PendingWrite& change);
  /// Advances the cursor to `to` or to a numerical stop, in pieces of work. Throws Stopped if the
  /// call is to end before, and StatusError if the server ends: the error then has the state where
  /// the cursor stopped.
  void advance(const Session& session, Cursor& cursor, std::int64_t to);
  /// Sends a message and frees it; the last one goes together with the status. For one thread at a
  /// time: that of the call, or one that helps it. Throws StatusError if the caller has left.
  template <class Writer, class Message>
  void write(Writer& writer, Message& message, bool last = false) {
    log_->tell_numerics();
    const grpc::ByteBuffer bytes = to_bytes(message);
    message = Message();
    grpc::WriteOptions options;
    if (last) options.set_last_message();
    const auto send = [&] { return writer.Write(bytes, options); };
    const bool helps = std::this_thread::get_id() != thread_;
    if (!(helps ? send() : turn_->without_place(send))) leave();
  }
  /// Reads the next message of a stream; returns whether there is one.
  template <class Reader, class Message>
  bool next(Reader& reader, Message& message) {
    host_.lifecycle.leave();
    const bool is_there = turn_->without_place([&] { return reader.Read(&message); });
    host_.lifecycle.enter();
    return is_there;
  }

  /// Returns the status that the caller is told for the exception that is handled.
  grpc::Status current_error() const;
  /// Writes the log line. The memory and the place of the call are given back when this object is
  /// destroyed, after its reply is sent.
  void end(const grpc::Status& status);

  Host& host() const { return host_; }
  CallLog& log() { return *log_; }
  Account& account() const { return *account_; }
  /// The measured work of the call, or of this request of a Drive, so far, in instructions. For the
  /// thread of the call.
  double work() const {
    const std::chrono::duration<double, std::nano> spent = turn_->spent();
    return spent.count() * instructions_a_nanosecond;
  }
  /// Requests a stop when the caller leaves, and where a piece of work goes on although the server
  /// ends its calls or the call has computed for as long as it may.
  const std::stop_token& stop() const { return stop_; }
  bool caller_left() const { return context_.IsCancelled(); }
  const Principal& principal() const { return account_->principal(); }
  grpc::ServerContext& context() const { return context_; }

 private:
  /// The most bytes of a request that is read in less than the free time of a turn.
  static constexpr std::size_t short_request = 4 << 10;

  const google::protobuf::Message& read(grpc::ByteBuffer& bytes,
                                        const google::protobuf::Message& prototype);
  static grpc::ByteBuffer to_bytes(const google::protobuf::Message& message);
  [[noreturn]] static void leave();
  /// Ends the turn, and tells the log how long the call has computed.
  struct Computed {
    explicit Computed(ServerCall& call) : of(call) {}
    ~Computed();
    ServerCall& of;
  };

  Host& host_;
  grpc::ServerContext& context_;
  const std::thread::id thread_ = std::this_thread::get_id();
  std::optional<CallLog> log_;
  Account* account_ = nullptr;
  Callers* callers_ = nullptr;
  bool counted_ = false;
  std::stop_source stop_source_;
  std::stop_token stop_ = stop_source_.get_token();
  std::optional<Turns::OfCall> turn_;
  ReadRequest request_;
  MemoryLease memory_;
};

}  // namespace stiefel::server
