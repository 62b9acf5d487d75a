#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/drive.h"
#include "stiefel/client/stream.h"

namespace stiefel::client {

/// A simulation held by a server: a pure function from step index to state. Steps are absolute,
/// ≥ 0. Deleted from the server on destruction unless kept. Different threads may call it at once.
///
/// A session from Client::create or fork outlives its server: where it is gone, a call creates it
/// again, with the last checkpoint that has come, and goes on. A deleted one stays deleted.
class Session {
 public:
  /// `base`: the scene that `description.scene` completes. A session that is `kept` is one that
  /// this handle found, and never creates. `checkpoint`: with which it was created.
  Session(std::shared_ptr<const Connection> connection, v1::Session description, v1::Scene base,
          bool kept, std::string checkpoint = "");
  ~Session();
  Session(Session&& other) noexcept = default;
  Session& operator=(Session&&) = delete;

  const std::string& id() const { return description_.session_id(); }
  /// The resolved scene, every default filled in. Arrays that the client does not have and that are
  /// too large for a reply are fetched by the first call, which then throws Error if it fails.
  const v1::Scene& scene() const;
  /// The method that the server chose for the scene's tolerance; null for a scene that names its
  /// method.
  const v1::Choice* choice() const {
    return description_.has_choice() ? &description_.choice() : nullptr;
  }
  /// The reply to its creation; its `scene` has only what the server filled in.
  const v1::Session& description() const { return description_; }
  /// As it is now, without a scene. Throws Error.
  v1::Session refresh() const;

  /// The state at step `to`, or the last good one before; see the reply's run status. A state too
  /// large for one reply comes over a stream. Throws Error.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {}) const;
  /// `step` with a checkpoint that Client::create accepts.
  v1::StepResponse checkpoint(std::int64_t to) const;
  /// `step` over a call that stays open.
  Drive drive() const;
  Stream stream(Range range) const;
  /// The invariants at step `to`, only the families or single ones named, all of them if none is.
  v1::DiagnoseResponse diagnose(std::int64_t to,
                                const std::vector<std::string>& invariants = {}) const;
  /// A diagnosis with two-forms and brackets; the session's id is filled in.
  v1::DiagnoseResponse diagnose(v1::DiagnoseRequest request) const;

  /// Statistics, events and states at times; the session's id is filled in. `receive` gets events
  /// and states as they come, each batch whole, and ends the call by returning false. The result is
  /// the last message with all statistics, empty if the receiver ended the call; in its checkpoint
  /// the data of the last one that came. A call that breaks goes on from its last checkpoint, or
  /// begins again, unless events or states would come twice. Throws Error.
  using SummaryReceiver = std::function<bool(const v1::SummarizeResponse&)>;
  v1::SummarizeResponse summarize(v1::SummarizeRequest request,
                                  const SummaryReceiver& receive = {}) const;

  /// A new session that starts where this one is at step `from_step`, with what the request
  /// changes; ids are filled in where they are empty. Throws Error, also when that step cannot be
  /// reached.
  Session fork(v1::ForkSessionRequest request) const;

  /// Leaves the session on the server, where other clients may attach to it.
  void keep() { kept_ = true; }

 private:
  struct ResolvedScene;

  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields,
                        bool return_checkpoint) const;

  std::shared_ptr<const Connection> connection_;
  v1::Session description_;
  std::shared_ptr<ResolvedScene> scene_;
  std::shared_ptr<Recreation> recreation_;
  bool kept_;
};

}  // namespace stiefel::client
