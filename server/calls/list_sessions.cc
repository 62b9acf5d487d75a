#include <algorithm>
#include <string>

#include "server/calls/requests.h"
#include "server/calls/service.h"
#include "server/convert/convert.h"
#include "server/convert/memory_price.h"

namespace stiefel::server {
namespace {

/// The sessions of a page of ListSessions.
constexpr std::size_t default_page_size = 100, max_page_size = 1000;

}  // namespace

void ListSessions(ServerCall& call, const v1::ListSessionsRequest& request,
                  v1::ListSessionsResponse* response) {
  const std::string& after = request.page_token();  // the last id of the page before
  if (!after.empty()) check_session_id(after, "page_token");
  const std::size_t size = request.page_size() == 0
                               ? default_page_size
                               : std::min<std::size_t>(request.page_size(), max_page_size);
  // One more session than asked for tells whether more follow.
  const Registry& registry = call.host().registry;
  const auto sessions = registry.page(call.principal(), after, size + 1);
  for (std::size_t i = 0; i < std::min(size, sessions.size()); ++i)
    to_list(*sessions[i], registry, response->add_sessions());
  if (sessions.size() > size) response->set_next_page_token(sessions[size - 1]->id());
}

}  // namespace stiefel::server
