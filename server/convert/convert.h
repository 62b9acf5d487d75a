#pragma once

#include <expected>
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

/// The same of single matrices, which must be finite, and back.
std::expected<Block, Violations> from_proto(const std::string& path, const v1::Matrix& matrix);
void to_proto(const RowMatrix& values, v1::Matrix* out);

void to_proto(const Catalogue& catalogue, v1::DescribeResponse* out);
void to_proto(const Session& session, const Registry& registry, v1::Session* out);
void to_proto(const RunStatus& run_status, v1::RunStatus* out);
/// How a cursor over states of `scene` ended, with the sentence for its last good state.
void to_proto(const Cursor& cursor, const Scene& scene, v1::RunStatus* out);
void to_proto(const Diagnosis& diagnosis, v1::DiagnoseResponse* out);
void to_proto(const ErrorEstimate& estimate, v1::EstimatedError* out);

using FieldNames = google::protobuf::RepeatedPtrField<std::string>;

/// The fields' indices; the system's blocks when none is named.
std::expected<std::vector<std::size_t>, Violations> select_fields(const Session& session,
                                                                  const FieldNames& names);

/// Name and shape: {samples, members, rows, cols}, without `samples` when that is absent, and
/// `members` in ensembles only.
void describe_field(const Field& field, std::optional<std::size_t> samples, v1::Field* out);
/// The state as it is now.
void to_proto(const Session& session, const Simulation& simulation,
              const std::vector<std::size_t>& fields, v1::Sample* out);

}  // namespace stiefel::server
