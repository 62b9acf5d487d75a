#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/access/tls_context.h"
#include "server/transport/listener.h"

namespace stiefel::server {

/// Answers GET of one path over HTTP/1.1, on a thread of its own: other paths get 404, other
/// methods 405. A connection is for one request and is closed after the answer.
///
/// 16 connections of a listener are served at once; the next ones wait for one of these to end. A
/// connection has 2 s for its handshake and its request of at most 8 KiB, and 10 s to take the
/// answer.
class HttpServer {
 public:
  /// The body, of `content_type`. Where it throws, the connection ends without an answer.
  using Page = std::function<std::string()>;

  /// `tls` null: without TLS. Throws std::runtime_error where the system gives no descriptor.
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
