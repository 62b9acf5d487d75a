#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/access/tls_context.h"
#include "server/transport/listener.h"

namespace stiefel::server {

/// Answers GET of one path over HTTP/1.1, on a thread of its own: 404 for other paths, 405 for
/// other methods. A connection serves one request and is closed after the answer.
///
/// A connection has 2 s for its handshake and its request of at most 8 KiB, and 10 s to take the
/// answer. At most 32 connections are open at once: a further one takes the place of the oldest
/// without a request or, if all have sent theirs, of the oldest.
class HttpServer {
 public:
  /// Returns the body, of `content_type`. If it throws, the connection ends without an answer.
  using Page = std::function<std::string()>;

  /// Uses no TLS if `tls` is null. Throws std::runtime_error if the system gives no descriptor.
  HttpServer(std::vector<Listener> listeners, TlsContext tls, std::string path,
             std::string content_type, Page page);
  /// Stops listening and closes all connections.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stiefel::server
