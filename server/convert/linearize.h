#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "server/convert/parts.h"
#include "server/convert/resolve.h"
#include "server/sessions/session.h"
#include "stiefel/linearization.h"
#include "stiefel/lyapunov.h"
#include "stiefel/v1/linearization.pb.h"
#include "stiefel/v1/lyapunov.pb.h"

namespace stiefel::server {

/// Returns the most vectors that a Linearize moves: those of its request or, without, the numbers
/// of the state; and those of parameters.
std::int64_t most_vectors(const Session& session, const v1::LinearizeRequest& request);
/// Returns the predicted instructions of the vectors in one step.
double work_of_vectors(const Session& session, const v1::LinearizeRequest& request);
/// Returns the predicted instructions of a Linearize that starts from the state at `start`.
double linearize_work(const Session& session, const v1::LinearizeRequest& request,
                      std::int64_t start);
/// Returns the bytes of the vectors, of a simulation, and of a result.
std::uint64_t linearize_workspace(const Session& session, const v1::LinearizeRequest& request);

/// Answers a Linearize: moves the vectors and writes its messages.
class LinearizeAnswer {
 public:
  /// The request must outlive this object. `memory`: the bytes that the call holds.
  LinearizeAnswer(SessionLease session, const v1::LinearizeRequest& request, double work,
                  std::uint64_t memory)
      : session_(std::move(session)), request_(request), work_(work), memory_(memory) {}
  ~LinearizeAnswer();

  /// Leases the simulation. Throws Stopped (stiefel/stop.h), as do the functions below.
  grpc::Status make();
  bool made() const { return simulation_ != nullptr; }
  /// Advances by at most `steps` steps to the next result. Ends early on a stop request.
  grpc::Status advance(std::int64_t steps, const std::stop_token& stop);
  /// Whether a message can be written: a result, or the rest of one.
  bool has_message() const { return !parts_.empty() || at_result_; }
  /// Writes the next message over `message`. Returns whether it is the last message.
  bool next(v1::LinearizeResponse& message);
  std::int64_t computed_steps() const { return computed_; }

 private:
  grpc::Status begin();
  std::int64_t next_result() const;
  void add_result();

  const SessionLease session_;
  const v1::LinearizeRequest& request_;
  const double work_;
  const std::uint64_t memory_;
  std::unique_ptr<Simulation> simulation_;
  std::optional<Linearization> linearization_;
  RunStatus status_;
  Parts parts_;
  bool at_result_ = false, priced_ = false, finite_ = true, first_ = true;
  std::int64_t computed_ = 0;
};

/// The price of a LyapunovSpectrum, known before it runs.
struct LyapunovPrice {
  double of_step = 0;  ///< instructions of the vectors in one step
  double total = 0;    ///< the most instructions, with those of a second motion
  std::uint64_t bytes = 0;
};
LyapunovPrice lyapunov_price(const Session& session, const v1::LyapunovSpectrumRequest& request);

/// Answers a LyapunovSpectrum: moves the vectors and writes its messages.
class LyapunovAnswer {
 public:
  /// The request must outlive this object. `memory`: the bytes that the call holds.
  LyapunovAnswer(SessionLease session, const v1::LyapunovSpectrumRequest& request, double work,
                 std::uint64_t memory)
      : session_(std::move(session)), request_(request), work_(work), memory_(memory) {}
  ~LyapunovAnswer();

  /// Checks the checkpoint and leases the simulation. Throws Stopped (stiefel/stop.h), as do the
  /// functions below.
  grpc::Status make();
  bool made() const { return simulation_ != nullptr; }
  /// Advances by about `steps` steps. Ends early on a stop request.
  grpc::Status advance(std::int64_t steps, const std::stop_token& stop);
  /// Whether numbers, a checkpoint or the end are there to be sent.
  bool has_results() const { return due_ || ended_ || sent_ < checkpoint_.size(); }
  /// Writes the next message over `message`, without results the progress alone. Returns whether it
  /// is the last message.
  bool next(v1::LyapunovSpectrumResponse& message);
  std::int64_t computed_steps() const {
    return computed_ + (spectrum_ ? spectrum_->computed_steps() : 0);
  }

 private:
  grpc::Status read();
  grpc::Status begin();
  /// At most 64 checkpoints are sent on the way, and none for less than a second's work.
  std::int64_t steps_between_checkpoints() const;
  void take_checkpoint();

  const SessionLease session_;
  const v1::LyapunovSpectrumRequest& request_;
  const double work_;
  const std::uint64_t memory_;
  LyapunovDescription what_;
  std::string saved_;  ///< the content of the request's checkpoint
  std::int64_t start_ = 0, mark_ = 0, computed_ = 0;
  std::int64_t checkpoint_step_ = 0;  ///< of the last checkpoint
  std::unique_ptr<Simulation> simulation_;
  std::optional<LyapunovExponents> spectrum_;
  RunStatus status_;
  bool due_ = false, ended_ = false, priced_ = false, ignored_ = false;
  std::string checkpoint_;
  std::size_t sent_ = 0;
};

}  // namespace stiefel::server
