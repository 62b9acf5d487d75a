#include "server/durability/stored_session.h"

#include <cstring>
#include <sstream>
#include <string_view>

#include "server/convert/stored_scene.h"
#include "server/sessions/identity.h"
#include "server/sessions/numerics_id.h"

namespace stiefel::server {
namespace {

using Nanoseconds = std::chrono::nanoseconds;
using Time = std::chrono::system_clock::time_point;

/// Joins paths, which contain no line ends.
std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Resolution resolution_of(const StoredSession& row) {
  Resolution resolution{{split(row.filled_in), split(row.cleared)}, std::nullopt};
  if (row.choice)
    resolution.choice = ChosenMethod{row.choice->tolerance, row.choice->horizon, row.choice->reason,
                                     row.choice->error, row.choice->verified};
  return resolution;
}

/// Adopts the state of a checkpoint if it is of this session and fits into the memory; leaves it
/// out otherwise, since it is only a cache.
void adopt(const StoredCheckpoint& checkpoint, Session& session) {
  if (checkpoint.numerics_id != numerics_id() || checkpoint.identity != hash(session.identity()) ||
      checkpoint.step < 0 || checkpoint.step > Session::max_step ||
      checkpoint.state.size() != session.saved_size() * sizeof(double))
    return;
  std::vector<double> saved(session.saved_size());
  std::memcpy(saved.data(), checkpoint.state.data(), checkpoint.state.size());
  session.adopt_if_it_fits(checkpoint.step, saved);
}

}  // namespace

StoredSession to_row(const Session& session) {
  const Resolution& resolution = session.resolution();
  const auto created = session.create_time().time_since_epoch();
  StoredSession row{session.owner(),
                    session.id(),
                    std::chrono::duration_cast<Nanoseconds>(created).count(),
                    numerics_id(),
                    hash(session.identity()),
                    to_bytes(session.scene()),
                    joined(resolution.difference.filled_in),
                    joined(resolution.difference.cleared),
                    std::nullopt};
  if (const auto& choice = resolution.choice)
    row.choice = StoredChoice{choice->tolerance, choice->horizon, choice->reason, choice->error,
                              choice->verified};
  return row;
}

Restored from_row(const Store::Row& row, std::shared_ptr<const Clock> clock,
                  std::shared_ptr<const CheckpointKeys> keys, MemoryBudget& memory) {
  auto scene = scene_of(row.session.scene);
  if (!scene) return std::unexpected(std::move(scene.error()));
  auto session = std::make_shared<Session>(row.session.id, *std::move(scene), std::move(clock),
                                           resolution_of(row.session), std::move(keys), memory);
  if (row.session.numerics_id == numerics_id() && row.session.identity != hash(session->identity()))
    return std::unexpected("this build reads its scene as a different scene");
  session->set_owner(row.session.principal);
  session->set_create_time(
      Time(std::chrono::duration_cast<Time::duration>(Nanoseconds(row.session.create_time))));
  if (row.checkpoint) adopt(*row.checkpoint, *session);
  return session;
}

}  // namespace stiefel::server
