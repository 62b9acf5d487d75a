#pragma once

#include <prometheus/collectable.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stiefel::server {

class ServedCertificates;

/// Returns why metrics cannot be served on `address` (one that address_fault accepts): it is a Unix
/// socket, which Prometheus does not read; or other machines can reach it and it is not `guarded`
/// by TLS or permitted by --insecure.
std::optional<std::string> metrics_fault(const std::string& address, bool guarded);

/// Serves metrics over HTTP/1.1 at /metrics, in Prometheus's text format, on a thread of its own:
/// 404 for other paths, 405 for other methods than GET.
///
/// A connection serves one request. It has 2 s for its handshake and its request of at most 8 KiB,
/// and 10 s to take the answer. At most 32 connections are open at once: a further one takes the
/// place of the oldest without a request or, if all have sent theirs, of the oldest.
/// prometheus-cpp's own Exposer (civetweb) listens on no IPv6 address in Debian, takes key and
/// certificate from one file, and lets silent connections keep its threads from other readers.
class Exporter {
 public:
  using Metrics = std::vector<std::shared_ptr<prometheus::Collectable>>;

  /// Listens on every IP address of host:port; port 0 means a free one. Speaks TLS if
  /// `certificates` is not null; it must outlive this object. Throws std::runtime_error with the
  /// system's reason.
  Exporter(const std::string& address, Metrics metrics, const ServedCertificates* certificates);
  /// Stops listening and closes all connections.
  ~Exporter();
  Exporter(const Exporter&) = delete;
  Exporter& operator=(const Exporter&) = delete;

  /// The URL, "http://127.0.0.1:9464/metrics", or "https://..." with TLS.
  const std::string& url() const { return url_; }

 private:
  struct Parts;
  std::string url_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stiefel::server
