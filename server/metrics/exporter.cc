#include "server/metrics/exporter.h"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <utility>

#include "server/access/exposure.h"
#include "server/access/tls_context.h"
#include "server/address.h"
#include "server/transport/tcp_listener.h"

namespace stiefel::server {
namespace {

/// Returns all families as text, without those that cannot be made for want of memory.
std::string page(const Exporter::Metrics& metrics) {
  std::vector<prometheus::MetricFamily> families;
  for (const auto& one : metrics) {
    try {
      std::ranges::move(one->Collect(), std::back_inserter(families));
    } catch (const std::exception&) {
    }
  }
  return prometheus::TextSerializer().Serialize(families);
}

std::string url_of(const std::string& address, int port, bool encrypted) {
  return (encrypted ? "https://" : "http://") + address.substr(0, address.rfind(':') + 1) +
         std::to_string(port) + "/metrics";
}

}  // namespace

std::optional<std::string> metrics_fault(const std::string& address, bool guarded) {
  if (is_unix(address)) return "must be host:port, because Prometheus reads no Unix sockets";
  return guarded ? std::nullopt : exposure_fault(address);
}

Exporter::Exporter(const std::string& address, Metrics metrics,
                   const ServedCertificates* certificates)
    : Exporter(address, listen_on_tcp(address), std::move(metrics), certificates) {}

Exporter::Exporter(const std::string& address, std::vector<Listener> listeners, Metrics metrics,
                   const ServedCertificates* certificates)
    : url_(url_of(address, listeners.front().port, certificates != nullptr)),
      server_(std::move(listeners), certificates ? tls_context(*certificates) : TlsContext(),
              "/metrics", "text/plain; version=0.0.4; charset=utf-8",
              [metrics = std::move(metrics)] { return page(metrics); }) {}

}  // namespace stiefel::server
