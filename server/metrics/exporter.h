#pragma once

#include <prometheus/collectable.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace prometheus {
class Exposer;
}

namespace stiefel::server {

/// Why the metrics are not served on `address` (one that address_fault accepts): a Unix socket,
/// which Prometheus does not read; a host without IPv4 address, because Debian's CivetWeb has no
/// IPv6; or, unless `insecure`, an address that other machines reach, because the metrics have
/// neither TLS nor tokens.
std::optional<std::string> metrics_fault(const std::string& address, bool insecure);

/// Serves metrics over HTTP at /metrics, in Prometheus's text format.
class Exporter {
 public:
  using Metrics = std::vector<std::shared_ptr<prometheus::Collectable>>;

  /// Listens on every IPv4 address of host:port; port 0 becomes a free one. Throws
  /// std::runtime_error with the system's reason.
  Exporter(const std::string& address, Metrics metrics);
  ~Exporter();

  /// Where: "http://127.0.0.1:9464/metrics".
  const std::string& url() const { return url_; }

 private:
  Metrics metrics_;
  std::string url_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace stiefel::server
