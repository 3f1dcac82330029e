#pragma once

#include <cstdint>
#include <prometheus/metric_family.h>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "world/base/duration_histogram.hpp"

namespace aprsim::server {

/// Gathers metrics and writes them in Prometheus' text format, which is prometheus-cpp's part. Its
/// counters and registry are not used: all is counted where it happens, by who must wait for
/// nothing, and looked at when it is asked for.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;
  using Type = prometheus::MetricType;

  /// Begins a metric; its samples follow.
  void metric(std::string_view name, Type type, std::string_view help);
  /// One sample of the counter or gauge that was begun.
  void sample(double value, const Labels& labels = {});
  void sample(std::uint64_t value, const Labels& labels = {}) {
    sample(static_cast<double>(value), labels);
  }
  /// All samples of a histogram, in seconds.
  void histogram(const api::DurationHistogram::Counts& counts, const Labels& labels = {});

  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] prometheus::ClientMetric& add(const Labels& labels);

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace aprsim::server
