#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/assembly.h"
#include "stiefel/v1/simulation.pb.h"

/// Checks that a reply has what the protocol promises. A server, or what stands before it, may
/// answer anything; what breaks the protocol throws CorruptReply.
namespace stiefel::client {

void require(bool holds, const std::string& fault);

/// Throws CorruptReply if one of the message's fields `names`, which are never empty, is absent.
void check_present(const google::protobuf::Message& message,
                   std::initializer_list<const char*> names);

/// Checks the description of the session `id`.
void check_session(const v1::Session& session, const std::string& id, bool with_scene);
/// Checks that each block of a scene has as many numbers as its shape says.
void check_blocks(const v1::Scene& scene);

/// Checks that the outcome is a known one.
void check_outcome(const v1::RunStatus& status);
/// Checks that a run to step `to` that ended at `step` was at `to` exactly if it REACHED it.
void check_end(const v1::RunStatus& status, std::int64_t step, std::int64_t to);

/// Returns the field `to` of a request, the step to which the call goes; 0 if it has none.
std::int64_t last_step(const google::protobuf::Message& request);
/// Checks the reply of a unary call: its messages that are not `optional` are there, and a run
/// ended at the step that its outcome says.
void check_reply(const google::protobuf::Message& reply, const google::protobuf::Message& request);
/// Checks a reply of Step or Drive. `fields`: the names in force; none for the system's blocks.
void check_step(const v1::StepResponse& reply, std::int64_t to,
                const google::protobuf::RepeatedPtrField<std::string>& fields,
                bool with_checkpoint);
void check_diagnosis(const v1::DiagnoseResponse& reply, const v1::DiagnoseRequest& request);
/// Checks the geodesic of one pair, with its whole trajectory.
void check_geodesic(const v1::ConnectResponse& reply, const v1::ConnectRequest& request);
/// Checks the arrays that a Summarize sends at its end. `run`: how the run ended.
void check_statistics(const Fields& statistics, const v1::SummarizeRequest& request,
                      v1::Outcome run);

/// The names, types and shapes of the fields that arrive batch by batch: every batch has those of
/// the first.
class Layout {
 public:
  using Names = google::protobuf::RepeatedPtrField<std::string>;

  /// `wanted`: the names that were asked for; if empty, those of the system's blocks. `axes`: how
  /// many axes the array of a batch has; one more in an ensemble, if `members` says so.
  Layout(const Names& wanted, int axes, bool members)
      : wanted_(wanted.begin(), wanted.end()), axes_(axes), members_(members) {}

  /// `count`: the elements of the batch, which the first axis counts; nothing where the arrays are
  /// a single element.
  void check(const Fields& fields, std::optional<int> count);

 private:
  std::vector<std::string> wanted_;
  int axes_;
  bool members_;
  std::optional<std::vector<std::string>> first_;  ///< a text for each field
};

/// The steps of a stream's samples: from, from + every, ... and `to`, or the last good step where
/// the run stops.
class Steps {
 public:
  explicit Steps(const v1::StreamRequest& request)
      : next_(request.from()),
        every_(request.every() == 0 ? 1 : request.every()),
        to_(request.to()) {}

  /// Checks the steps and times of a message's samples.
  void check(const v1::StreamResponse& batch);
  /// Checks the end of a stream whose last sample was at step `last`; nothing without samples.
  void end(const v1::RunStatus& status, std::optional<std::int64_t> last) const;

 private:
  std::int64_t next_, every_, to_;
  bool over_ = false;
};

/// The parts of a trade-off, as they arrive: the setup, then the points, then the front.
class TradeoffParts {
 public:
  void check(const v1::MeasureTradeoffResponse& part);
  void end() const;
  bool begun() const { return last_ != v1::MeasureTradeoffResponse::PART_NOT_SET; }

 private:
  v1::MeasureTradeoffResponse::PartCase last_ = v1::MeasureTradeoffResponse::PART_NOT_SET;
  std::uint32_t points_ = 0;
};

}  // namespace stiefel::client
