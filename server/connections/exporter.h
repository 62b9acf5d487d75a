#pragma once

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stiefel::server {

/// Returns why metrics cannot be served on `address` (one that address_fault accepts): it is a Unix
/// socket or an IPv6 address, on which prometheus-cpp does not listen; or other machines can reach
/// it and `insecure` does not permit that.
std::optional<std::string> metrics_fault(const std::string& address, bool insecure);

/// Serves metrics over HTTP at /metrics, in Prometheus's text format, by prometheus-cpp.
class Exporter {
 public:
  using Metrics = std::vector<std::shared_ptr<prometheus::Collectable>>;

  /// Listens on host:port; port 0 means a free one. Throws std::runtime_error.
  Exporter(const std::string& address, Metrics metrics);

  /// The URL, "http://127.0.0.1:9464/metrics".
  const std::string& url() const { return url_; }

 private:
  const std::shared_ptr<prometheus::Collectable> page_;
  prometheus::Exposer exposer_;
  std::string url_;
};

}  // namespace stiefel::server
