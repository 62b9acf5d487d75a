#pragma once

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/convert/faults.h"
#include "server/sessions/cursor.h"
#include "server/sessions/registry.h"
#include "server/sessions/server_session.h"
#include "stiefel/catalogue.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/v1/common.pb.h"
#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/simulation.pb.h"

/// Converts between the wire's types and the engine's; no other code sees both.

namespace stiefel::server {

/// Converts a scene and checks what only the wire can get wrong: shapes and numbers of values.
/// Throws INVALID_ARGUMENT, whose violations name fields of `place`. Every field of a description
/// is read and written by its name, so that a field that the messages lack makes every call fail
/// (std::logic_error).
SceneDescription from_proto(const v1::Scene& scene, const Place& place = {});
MethodDescription from_proto(const v1::Method& method, const Place& place = {});
void to_proto(const SceneDescription& description, v1::Scene* out);
void to_proto(const MethodDescription& method, v1::Method* out);
void to_proto(const RowMatrix& values, v1::Matrix* out);

/// Writes the catalogue, the numerics id and the limits of the engine and of sessions.
void describe_engine(v1::DescribeResponse* out);
/// Writes a session, with its scene on request.
void to_proto(const RegisteredSession& session, const Registry& registry, bool with_scene,
              v1::Session* out);
/// Writes a session for ListSessions: only its id, system and times.
void to_list(const RegisteredSession& session, const Registry& registry, v1::Session* out);
void to_proto(const Choice& choice, v1::Choice* out);
/// Throws Stopped for a run that was stopped: it has no reply, its call ends with an error.
void to_proto(const RunStatus& run_status, v1::RunStatus* out);
/// Writes how a cursor over states of `scene` ended, with the sentence for its last good state.
void to_proto(const Cursor& cursor, const Scene& scene, v1::RunStatus* out);
/// Returns the value of the protocol for one of the engine, where both enumerations have the same
/// order: `first` is that for the engine's first value.
template <class Wire, class Engine>
constexpr Wire same_order(Engine value, Wire first) {
  return static_cast<Wire>(static_cast<int>(first) + static_cast<int>(value));
}

using FieldNames = google::protobuf::RepeatedPtrField<std::string>;

/// Returns the indices of the named fields; the session's default ones when no field is named.
/// Throws INVALID_ARGUMENT.
std::vector<std::size_t> select_fields(const Session& session, const FieldNames& names);

/// Writes the name, type and shape of a field: {samples, members, rows, cols}, without `samples`
/// when that is absent and with `members` in ensembles only, unless it is that of one member.
void describe_field(const Session& session, std::size_t index, std::optional<std::size_t> samples,
                    bool of_member, v1::Field* out);
/// Returns an array of doubles, row by row, of this name and shape.
v1::Field to_field(std::string_view name, std::initializer_list<Eigen::Index> shape,
                   std::span<const double> numbers);
inline v1::Field to_field(std::string_view name, const RowMatrix& values) {
  return to_field(name, {values.rows(), values.cols()},
                  {values.data(), static_cast<std::size_t>(values.size())});
}
/// Writes the simulation's current state.
void to_proto(const Session& session, const Simulation& simulation,
              const std::vector<std::size_t>& fields, v1::Sample* out);

/// Reads a block of a description. If the numbers of values do not match the shape, leaves `out`
/// unchanged and adds faults at `path`.
void read_block(const Path& path, const v1::Matrix& matrix, Block& out, Faults& faults);
/// Reads a block from a tensor of shape (rows, cols) or (members, rows, cols), with the members'
/// blocks stacked. Adds faults as for a matrix.
void read_block(const Path& path, const v1::Tensor& tensor, Block& out, Faults& faults);

/// Reads a single matrix, which must be finite. Adds faults and returns an empty one if it is
/// refused.
RowMatrix read_matrix(const Path& path, const v1::Matrix& matrix, Faults& faults);
/// As read_matrix; a matrix that is absent is a fault.
RowMatrix read_given(const Path& path, bool present, const v1::Matrix& matrix, Faults& faults);

void write_block(const Block& block, v1::Matrix* out);

/// Whether all numbers of the arrays are finite.
bool is_finite(const v1::Field& field);
bool is_finite(const google::protobuf::RepeatedPtrField<v1::Field>& fields);

/// Changes OUTCOME_REACHED to OUTCOME_NOT_FINITE unless `finite`.
void demand_finite(bool finite, v1::RunStatus* status);

}  // namespace stiefel::server
