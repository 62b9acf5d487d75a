#pragma once

#include <prometheus/metric_family.h>

#include <string>
#include <utility>
#include <vector>

namespace stiefel::server {

using Labels = std::vector<prometheus::ClientMetric::Label>;

/// Returns a family without metrics. Its help is one sentence.
inline prometheus::MetricFamily family(std::string name, std::string help,
                                       prometheus::MetricType type) {
  return {std::move(name), std::move(help), type, {}};
}

/// Adds a value to a family of counters or gauges.
inline void add_value(prometheus::MetricFamily& to, Labels labels, double value) {
  prometheus::ClientMetric metric;
  metric.label = std::move(labels);
  (to.type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  to.metric.push_back(std::move(metric));
}

/// Returns a family of one value.
inline prometheus::MetricFamily single(std::string name, std::string help,
                                       prometheus::MetricType type, double value,
                                       Labels labels = {}) {
  auto one = family(std::move(name), std::move(help), type);
  add_value(one, std::move(labels), value);
  return one;
}

}  // namespace stiefel::server
