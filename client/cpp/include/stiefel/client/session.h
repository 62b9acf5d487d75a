#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/drive.h"
#include "stiefel/client/stream.h"

namespace stiefel::client {

/// A handle to a simulation held by a server: a pure function from step index to state. Steps are
/// absolute and ≥ 0. Its destruction deletes the session from the server unless it was kept.
/// Thread-safe: several threads may call it at once.
///
/// A session from Client::create or fork survives the loss of its server: the next call creates it
/// again, from the checkpoints that have arrived, and goes on. A deleted session stays deleted.
class Session {
 public:
  /// `base`: the scene that `description.scene` completes. `kept`: whether the handle attaches to a
  /// session that it did not create; it then neither deletes the session nor creates it again.
  /// `checkpoint`: the checkpoint with which the session was created.
  Session(std::shared_ptr<const Connection> connection, v1::Session description, v1::Scene base,
          bool kept, std::string checkpoint = "");
  ~Session();
  Session(Session&& other) noexcept = default;
  Session& operator=(Session&&) = delete;

  const std::string& id() const { return description_.session_id(); }
  /// Returns the resolved scene, every default filled in. The first call fetches arrays that were
  /// too large for the server's reply and that the client does not have; it throws Error if that
  /// fails.
  const v1::Scene& scene() const;
  /// Returns the method that the server chose for the scene's tolerance; null if the scene has no
  /// tolerance.
  const v1::Choice* choice() const {
    return description_.has_choice() ? &description_.choice() : nullptr;
  }
  /// The server's reply when this handle began. For a session that this handle created, `scene` has
  /// only what the server filled in.
  const v1::Session& description() const { return description_; }
  /// Asks the server for the session's present description, without a scene. Throws Error.
  v1::Session refresh() const;

  /// Returns the state at step `to`, or the last good one if the run ended before; see the reply's
  /// run status. A state too large for one reply is fetched over a stream. Throws Error.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {}) const;
  /// Does what `step` does and adds a checkpoint, which Client::create accepts. Throws Error.
  v1::StepResponse checkpoint(std::int64_t to) const;
  /// Opens a call for many steps in a tight loop.
  Drive drive() const;
  /// Opens a stream of samples.
  Stream stream(Range range) const;
  /// Returns the invariants at step `to`. `invariants`: names of families or of single invariants;
  /// every family if empty. Throws Error.
  v1::DiagnoseResponse diagnose(std::int64_t to,
                                const std::vector<std::string>& invariants = {}) const;
  /// Returns all that the request asks for, such as two-forms and Dirac brackets; the session's id
  /// is filled in. Throws Error.
  v1::DiagnoseResponse diagnose(v1::DiagnoseRequest request) const;

  /// Makes any call about this session that has one reply, for example
  /// `session.call(&v1::SimulationService::Stub::Diagnose, request)`; the session's id is filled
  /// in. Throws Error.
  template <class Request, class Reply>
  Reply call(Connection::Method<Request, Reply> method, Request request) const {
    request.set_session_id(id());
    Reply reply;
    answer(request, reply, [&] {
      reply = connection_->call(method, request, connection_->options.compute_timeout,
                                recreation_.get());
    });
    return reply;
  }

  /// Computes statistics, events and states at times on the server; the session's id is filled in.
  /// `receive` gets events and states as they come, each batch whole, and ends the call by
  /// returning false. Returns the last message with all statistics and the data of the last
  /// checkpoint that came; an empty message if the receiver ended the call. A call that breaks is
  /// resumed from its last checkpoint, or begins again; if necessary the session is created again.
  /// `receive` gets every event and state once. Throws Error.
  using SummaryReceiver = std::function<bool(const v1::SummarizeResponse&)>;
  v1::SummarizeResponse summarize(v1::SummarizeRequest request,
                                  const SummaryReceiver& receive = {}) const;

  /// Computes the derivative of the steps; the session's id is filled in. `receive` gets each
  /// result whole and once, and ends the call by returning false. Returns the last message; an
  /// empty one if the receiver ended the call. A call that breaks begins again. Throws Error.
  using LinearizationReceiver = std::function<bool(const v1::LinearizeResponse&)>;
  v1::LinearizeResponse linearize(v1::LinearizeRequest request,
                                  const LinearizationReceiver& receive = {}) const;

  /// Computes Lyapunov exponents; the session's id is filled in. `receive` gets the numbers on the
  /// way, and messages without numbers that say how far the call is; it ends the call by returning
  /// false. Returns the last message, with the whole checkpoint; an empty one if the receiver ended
  /// the call. A call that breaks begins again. Throws Error.
  using SpectrumReceiver = std::function<bool(const v1::LyapunovSpectrumResponse&)>;
  v1::LyapunovSpectrumResponse lyapunov(v1::LyapunovSpectrumRequest request,
                                        const SpectrumReceiver& receive = {}) const;

  /// Creates a session that starts from this one's state at step `from_step`, with the changes that
  /// the request names. An empty `session_id` is replaced by a new UUID; `from_session_id` is
  /// filled in. Throws Error, also when the step cannot be reached.
  Session fork(v1::ForkSessionRequest request) const;

  /// Leaves the session on the server, where other clients may attach to it.
  void keep() { kept_ = true; }

 private:
  struct ResolvedScene;

  /// Makes a call that sets the reply, and checks that the reply has what every reply has.
  void answer(const google::protobuf::Message& request, const google::protobuf::Message& reply,
              const std::function<void()>& call) const;
  /// Does what `scene` does. `handle` says whether a lost session is created again for it.
  const v1::Scene& scene(Recreation& handle) const;
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields,
                        bool return_checkpoint) const;

  std::shared_ptr<const Connection> connection_;
  v1::Session description_;
  std::shared_ptr<ResolvedScene> scene_;
  std::shared_ptr<Recreation> recreation_;
  bool kept_;
};

}  // namespace stiefel::client
