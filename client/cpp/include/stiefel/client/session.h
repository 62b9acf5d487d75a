#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stiefel/client/drive.h"
#include "stiefel/client/stream.h"

namespace stiefel::client {

/// A simulation held by a server: a pure function from step index to state. Steps are absolute,
/// ≥ 0. Deleted from the server on destruction unless kept. Different threads may call it at once.
class Session {
 public:
  Session(std::shared_ptr<const Connection> connection, v1::Session description, bool kept);
  ~Session();
  Session(Session&& other) noexcept = default;
  Session& operator=(Session&&) = delete;

  const std::string& id() const { return description_.session_id(); }
  /// The resolved scene, every default filled in.
  const v1::Scene& scene() const { return description_.scene(); }
  /// As it was when it was created.
  const v1::Session& description() const { return description_; }
  /// As it is now. Throws Error.
  v1::Session refresh() const;

  /// The state at step `to`, or the last good one before; see the reply's run status. Throws Error.
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields = {}) const;
  /// The same, and a checkpoint that Client::create accepts.
  v1::StepResponse checkpoint(std::int64_t to) const;
  /// `step` over a call that stays open.
  Drive drive() const;
  Stream stream(Range range) const;
  /// The invariants at step `to`, only the families or single ones named, all of them if none is.
  v1::DiagnoseResponse diagnose(std::int64_t to,
                                const std::vector<std::string>& invariants = {}) const;
  /// The same with two-forms and brackets; the session's id is filled in.
  v1::DiagnoseResponse diagnose(v1::DiagnoseRequest request) const;

  /// A new session that starts where this one is at step `from_step`, with what the request
  /// changes; ids are filled in where they are empty. Throws Error, also when that step cannot be
  /// reached.
  Session fork(v1::ForkSessionRequest request) const;

  /// Leaves the session on the server, where other clients may attach to it.
  void keep() { kept_ = true; }

 private:
  v1::StepResponse step(std::int64_t to, const std::vector<std::string>& fields,
                        bool checkpoint) const;

  std::shared_ptr<const Connection> connection_;
  v1::Session description_;
  bool kept_;
};

}  // namespace stiefel::client
