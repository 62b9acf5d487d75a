#include "server/connections/exporter.h"

#include <prometheus/metric_family.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "server/connections/listener.h"

namespace stiefel::server {
namespace {

/// All metrics, without those that cannot be made for want of memory: no exception may pass the C
/// code of civetweb.
class Page final : public prometheus::Collectable {
 public:
  explicit Page(Exporter::Metrics metrics) : metrics_(std::move(metrics)) {}

  std::vector<prometheus::MetricFamily> Collect() const override {
    std::vector<prometheus::MetricFamily> families;
    for (const auto& one : metrics_) {
      try {
        std::ranges::move(one->Collect(), std::back_inserter(families));
      } catch (const std::exception&) {
      }
    }
    return families;
  }

 private:
  const Exporter::Metrics metrics_;
};

/// A silent connection holds one of the threads until the time for its request is over.
std::vector<std::string> settings(const std::string& address) {
  return {"listening_ports", address, "num_threads", "4", "request_timeout_ms", "2000"};
}

}  // namespace

std::optional<std::string> metrics_fault(const std::string& address, bool insecure) {
  if (is_unix(address) || address.starts_with('['))
    return "must be host:port with a name or an IPv4 address";
  if (insecure || std::ranges::all_of(tcp_addresses(address), is_local)) return std::nullopt;
  return "other machines can reach it: give --insecure, and a network policy";
}

Exporter::Exporter(const std::string& address, Metrics metrics) try
    : page_(std::make_shared<Page>(std::move(metrics))), exposer_(settings(address)) {
  exposer_.RegisterCollectable(page_);
  url_ = "http://" + address.substr(0, address.rfind(':') + 1) +
         std::to_string(exposer_.GetListeningPorts().front()) + "/metrics";
} catch (const std::exception& fault) {
  throw std::runtime_error("cannot serve metrics on " + address + ": " + fault.what());
}

}  // namespace stiefel::server
