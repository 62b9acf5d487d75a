#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "server/convert/tangents/linearize_answer.h"
#include "stiefel/lyapunov.h"
#include "stiefel/v1/tangents.pb.h"

namespace stiefel::server {

/// Returns the bytes of the vectors and of a simulation.
std::uint64_t tangent_workspace(const Session& session, const v1::LyapunovSpectrumRequest& request);

/// Answers a LyapunovSpectrum: moves the vectors and writes its messages.
class LyapunovAnswer {
 public:
  /// Checks the checkpoint and acquires the simulation. The request must outlive this object.
  /// Throws Stopped (stiefel/stop.h), as `advance` does.
  LyapunovAnswer(SessionRef session, const v1::LyapunovSpectrumRequest& request);
  ~LyapunovAnswer();

  /// Advances by about `steps` steps. Ends early on a stop request.
  void advance(std::int64_t steps, const std::stop_token& stop);
  /// Makes a last checkpoint, unless a stop has `interrupted` a step. Returns whether there is
  /// anything to send.
  bool save(bool interrupted);
  /// Whether numbers, a checkpoint or the end are there to be sent.
  bool has_results() const { return due_ || ended_ || !checkpoint_.empty(); }
  /// Writes the next message over `message`, without results the progress alone. Returns whether it
  /// is the last message.
  bool next(v1::LyapunovSpectrumResponse& message);
  std::int64_t computed_steps() const {
    return computed_ + (spectrum_ ? spectrum_->computed_steps() : 0);
  }

 private:
  void begin();
  /// Whether a checkpoint is due: at most 64 are sent on the way.
  bool checkpoint_is_due() const;
  void take_checkpoint();

  const SessionRef session_;
  const v1::LyapunovSpectrumRequest& request_;
  const LyapunovDescription what_;
  std::string saved_;  ///< the content of the request's checkpoint
  std::int64_t start_ = 0, mark_ = 0, computed_ = 0;
  std::int64_t checkpoint_step_ = 0, covered_ = 0;  ///< at the last checkpoint
  SimulationPtr simulation_;
  std::unique_ptr<LyapunovExponents> spectrum_;
  RunStatus status_;
  bool due_ = false, ended_ = false;
  std::string checkpoint_;  ///< not yet sent
};

}  // namespace stiefel::server
