#include <algorithm>
#include <cstdint>
#include <string>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
namespace {

/// The sessions and the bytes of a page of ListSessions.
constexpr std::size_t default_page_size = 100, max_page_size = 1000, page_bytes = 2 << 20;

}  // namespace

void ListSessions(ServerCall& call, const v1::ListSessionsRequest& request,
                  v1::ListSessionsResponse* response) {
  const std::string& after = request.page_token();  // the last id of the page before
  if (!after.empty()) check_session_id(after, "page_token");
  const std::size_t size = request.page_size() == 0
                               ? default_page_size
                               : std::min<std::size_t>(request.page_size(), max_page_size);
  // A list without scenes is never refused, so that a caller beyond the limits finds its sessions.
  const bool scenes = shows_scenes(request.view());
  if (scenes) call.hold(memory_price({.reply = page_bytes}));
  // One more session than asked for tells whether more follow.
  const Registry& registry = call.host().registry;
  const auto sessions = registry.page(call.principal(), after, size + 1);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    v1::Session session;
    if (scenes)
      call.memory().grow_to(memory_price({.reply = page_bytes + scene_reply(*sessions[i])}));
    if (i < size) to_list(*sessions[i], registry, request.view(), &session);
    bytes += session.ByteSizeLong();
    if (i == size || (i > 0 && bytes > page_bytes)) {
      response->set_next_page_token(sessions[i - 1]->id());
      break;
    }
    *response->add_sessions() = std::move(session);
    call.pass();
  }
}

}  // namespace stiefel::server
