#pragma once

#include <expected>
#include <functional>
#include <string>
#include <vector>

#include "server/sessions/cursor.h"
#include "server/sessions/registry.h"
#include "server/sessions/session.h"
#include "stiefel/diagnosis.h"
#include "stiefel/error_estimate.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#include "stiefel/v1/simulation.pb.h"

/// Between the wire's types and the engine's; no other code sees both.
namespace stiefel::server {

/// Checks what only the wire can get wrong: shapes and numbers of values. The violations are of the
/// fields of `place`. Every field of a description is read and written under its name, so that one
/// that the messages lack is an error of every call (std::logic_error).
std::expected<SceneDescription, Violations> from_proto(const v1::Scene& scene,
                                                       const Place& place = {});
std::expected<MethodDescription, Violations> from_proto(const v1::Method& method,
                                                        const Place& place = {});
void to_proto(const SceneDescription& description, v1::Scene* out);
void to_proto(const MethodDescription& method, v1::Method* out);
/// Of the fields, by their paths in the scene, those that are wanted: "step", "method.order",
/// "initial.Q".
using Selection = std::function<bool(std::string_view path)>;
void to_proto(const SceneDescription& description, const Selection& wanted, v1::Scene* out);

/// The same of single matrices, which must be finite, and back.
std::expected<Block, Violations> from_proto(const std::string& path, const v1::Matrix& matrix);
void to_proto(const RowMatrix& values, v1::Matrix* out);

/// The catalogue, the numerics id, and the limits that are the engine's or a session's.
void describe_engine(v1::DescribeResponse* out);
/// As the view asks; `resolution` is how the caller's scene became the session's.
void to_proto(const Session& session, const Resolution& resolution, const Registry& registry,
              const v1::SessionView& view, v1::Session* out);
/// The method of a scene, and what it was chosen for.
void to_proto(const Scene& scene, const ChosenMethod& choice, v1::Choice* out);
/// Id, system and times alone; the view's scene, if it asks for one, as it was filled in for the
/// session's creator.
void to_list(const Session& session, const Registry& registry, const v1::SessionView& view,
             v1::Session* out);
void to_proto(const RunStatus& run_status, v1::RunStatus* out);
/// How a cursor over states of `scene` ended, with the sentence for its last good state.
void to_proto(const Cursor& cursor, const Scene& scene, v1::RunStatus* out);
void to_proto(const Diagnosis& diagnosis, v1::DiagnoseResponse* out);
void to_proto(const ErrorEstimate& estimate, v1::EstimatedError* out);

using FieldNames = google::protobuf::RepeatedPtrField<std::string>;

/// The fields' indices; the system's blocks when none is named.
std::expected<std::vector<std::size_t>, Violations> select_fields(const Session& session,
                                                                  const FieldNames& names);

/// Name, type and shape: {samples, members, rows, cols}, without `samples` when that is absent, and
/// `members` in ensembles only.
void describe_field(const Session& session, const Field& field, std::optional<std::size_t> samples,
                    v1::Field* out);
/// Bytes of the fields at one step.
std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields);
/// The state as it is now, without checksum.
void to_proto(const Session& session, const Simulation& simulation,
              const std::vector<std::size_t>& fields, v1::Sample* out);

}  // namespace stiefel::server
