#include "server/metrics/exporter.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <prometheus/exposer.h>
#include <prometheus/metric_family.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "server/access/exposure.h"
#include "server/address.h"
#include "server/transport/listener.h"
#include "server/transport/tcp_listener.h"

namespace stiefel::server {
namespace {

bool is_ipv4(const SocketAddress& address) { return address.storage.ss_family == AF_INET; }

std::string text_of(const Listener& listener) {
  const auto& address = reinterpret_cast<const sockaddr_in&>(listener.address.storage);
  char ip[INET_ADDRSTRLEN] = {};
  inet_ntop(AF_INET, &address.sin_addr, ip, sizeof ip);
  return std::string(ip) + ":" + std::to_string(listener.port);
}

/// The IPv4 addresses in the form of CivetWeb. They are free: each was listened on just now, which
/// also gives the reason where one is not.
std::string civetweb_ports(const std::string& address, int& port) {
  std::string all;
  for (const Listener& listener : listen_on_tcp(address)) {
    port = listener.port;
    if (!is_ipv4(listener.address)) continue;
    if (!all.empty()) all += ',';
    all += text_of(listener);
  }
  return all;
}

/// Metrics that are left out of an answer for which they cannot be made: the HTTP server is C and
/// would end the process with an exception.
class LeftOut final : public prometheus::Collectable {
 public:
  explicit LeftOut(std::shared_ptr<prometheus::Collectable> metrics)
      : metrics_(std::move(metrics)) {}
  std::vector<prometheus::MetricFamily> Collect() const override {
    try {
      return metrics_->Collect();
    } catch (const std::exception&) {
      return {};
    }
  }

 private:
  const std::shared_ptr<prometheus::Collectable> metrics_;
};

}  // namespace

std::optional<std::string> metrics_fault(const std::string& address, bool insecure) {
  if (is_unix(address)) return "must be host:port: Prometheus reads no Unix sockets";
  const std::vector<SocketAddress> addresses = tcp_addresses(address);
  if (!addresses.empty() && std::ranges::none_of(addresses, is_ipv4))
    return "must have an IPv4 address: the HTTP server has no IPv6";
  if (insecure || std::ranges::all_of(addresses, is_local)) return std::nullopt;
  return "other machines reach it, and metrics have neither TLS nor tokens: give --insecure";
}

Exporter::Exporter(const std::string& address, Metrics metrics) {
  for (auto& one : metrics) metrics_.push_back(std::make_shared<LeftOut>(std::move(one)));
  int port = 0;
  const std::string ports = civetweb_ports(address, port);
  // Four readers at once, each with two seconds to send its request.
  const std::vector<std::string> options{"listening_ports",    ports, "num_threads", "4",
                                         "request_timeout_ms", "2000"};
  try {
    exposer_ = std::make_unique<prometheus::Exposer>(options);
  } catch (const std::exception& fault) {
    throw std::runtime_error("cannot listen on " + address + ": " + fault.what());
  }
  for (const auto& one : metrics_) exposer_->RegisterCollectable(one);
  url_ = "http://" + address.substr(0, address.rfind(':') + 1) + std::to_string(port) + "/metrics";
}

Exporter::~Exporter() = default;

}  // namespace stiefel::server
