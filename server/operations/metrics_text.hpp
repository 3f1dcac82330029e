#pragma once

#include <cstdint>
#include <prometheus/metric_family.h>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "world/base/duration_histogram.hpp"

namespace aprsim::server {

/// Collects metrics and writes them in Prometheus' text format by prometheus-cpp. Its counters and
/// registry are not used: threads that must not block count by themselves, and a request reads the
/// counts.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;
  using Type = prometheus::MetricType;

  /// Begins a metric; its samples follow.
  void metric(std::string_view name, Type type, std::string_view help);
  /// Adds a sample of the current counter or gauge.
  void sample(double value, const Labels& labels = {});
  void sample(std::uint64_t value, const Labels& labels = {}) {
    sample(static_cast<double>(value), labels);
  }
  /// Adds all samples of a histogram, in seconds.
  void histogram(const api::DurationHistogram::Counts& counts, const Labels& labels = {});

  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] prometheus::ClientMetric& add(const Labels& labels);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace aprsim::server
