#pragma once

#include <prometheus/collectable.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/metrics/http_server.h"

namespace stiefel::server {

class ServedCertificates;

/// Why the metrics are not served on `address` (one that address_fault accepts): a Unix socket,
/// which Prometheus does not read; or, unless `guarded` by TLS or allowed by --insecure, an address
/// that other machines reach.
std::optional<std::string> metrics_fault(const std::string& address, bool guarded);

/// Serves metrics over HTTP at /metrics, in Prometheus's text format.
class Exporter {
 public:
  using Metrics = std::vector<std::shared_ptr<prometheus::Collectable>>;

  /// Listens on every IP address of host:port; port 0 becomes a free one. With `certificates`,
  /// which outlive it, it speaks TLS (tls_context.h). Throws std::runtime_error with the system's
  /// reason.
  Exporter(const std::string& address, Metrics metrics, const ServedCertificates* certificates);

  /// Where: "http://127.0.0.1:9464/metrics", with TLS "https://...".
  const std::string& url() const { return url_; }

 private:
  Exporter(const std::string& address, std::vector<Listener> listeners, Metrics metrics,
           const ServedCertificates* certificates);

  std::string url_;
  HttpServer server_;
};

}  // namespace stiefel::server
