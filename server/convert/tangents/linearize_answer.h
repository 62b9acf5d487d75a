#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>

#include "server/convert/resolve.h"
#include "server/sessions/registry.h"
#include "stiefel/linearization.h"
#include "stiefel/v1/tangents.pb.h"

namespace stiefel::server {

/// Returns the numbers of the blocks of a session's state.
std::int64_t state_size(const Session& session);

/// Returns the bytes of the vectors, of a simulation, and of a result.
std::uint64_t tangent_workspace(const Session& session, const v1::LinearizeRequest& request);

/// Answers a Linearize: moves the vectors and writes its messages.
class LinearizeAnswer {
 public:
  /// The request must outlive this object. Throws Stopped (stiefel/stop.h), as `advance` does.
  LinearizeAnswer(SessionRef session, const v1::LinearizeRequest& request)
      : session_(std::move(session)),
        request_(request),
        simulation_(session_->acquire(request.from())) {}
  ~LinearizeAnswer();

  /// Advances by at most `steps` steps to the next result. Ends early on a stop request.
  void advance(std::int64_t steps, const std::stop_token& stop);
  /// Whether a result is there to be sent.
  bool has_results() const { return at_result_; }
  /// There is no checkpoint to make. Returns whether there is anything to send.
  bool save(bool interrupted) const { return !interrupted && has_results(); }
  /// Writes the next message over `message`. Returns whether it is the last message.
  bool next(v1::LinearizeResponse& message);
  std::int64_t computed_steps() const { return computed_; }

 private:
  void begin();
  std::int64_t next_result() const;
  void add_result();

  const SessionRef session_;
  const v1::LinearizeRequest& request_;
  SimulationPtr simulation_;
  std::unique_ptr<Linearization> linearization_;
  RunStatus status_;
  google::protobuf::RepeatedPtrField<v1::Field> fields_;  ///< of the next result
  bool at_result_ = false, finite_ = true;
  std::int64_t computed_ = 0;
};

}  // namespace stiefel::server
