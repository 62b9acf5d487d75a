#pragma once

#include <prometheus/collectable.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/metrics/http_server.h"

namespace stiefel::server {

class ServedCertificates;

/// Returns why metrics cannot be served on `address` (one that address_fault accepts): it is a Unix
/// socket, which Prometheus does not read; or other machines can reach it and it is not `guarded`
/// by TLS or permitted by --insecure.
std::optional<std::string> metrics_fault(const std::string& address, bool guarded);

/// Serves metrics over HTTP at /metrics, in Prometheus's text format.
class Exporter {
 public:
  using Metrics = std::vector<std::shared_ptr<prometheus::Collectable>>;

  /// Listens on every IP address of host:port; port 0 means a free one. Speaks TLS (tls_context.h)
  /// if `certificates` is not null; it must outlive this object. Throws std::runtime_error with the
  /// system's reason.
  Exporter(const std::string& address, Metrics metrics, const ServedCertificates* certificates);

  /// The URL, "http://127.0.0.1:9464/metrics", or "https://..." with TLS.
  const std::string& url() const { return url_; }

 private:
  Exporter(const std::string& address, std::vector<Listener> listeners, Metrics metrics,
           const ServedCertificates* certificates);

  std::string url_;
  HttpServer server_;
};

}  // namespace stiefel::server
