#include "server/operations/metrics_text.hpp"

#include <limits>
#include <prometheus/text_serializer.h>

namespace aprsim::server {

void MetricsText::metric(std::string_view name, Type type, std::string_view help) {
  families_.push_back({std::string(name), std::string(help), type, {}});
}

prometheus::ClientMetric& MetricsText::add(const Labels& labels) {
  auto& metric = families_.back().metric.emplace_back();
  for (const auto& [label, value] : labels) metric.label.push_back({std::string(label), value});
  return metric;
}

void MetricsText::sample(double value, const Labels& labels) {
  auto& metric = add(labels);
  (families_.back().type == Type::Counter ? metric.counter.value : metric.gauge.value) = value;
}

void MetricsText::histogram(const api::DurationHistogram::Counts& counts, const Labels& labels) {
  auto& histogram = add(labels).histogram;
  histogram.sample_count = counts.count;
  histogram.sample_sum = counts.sum_s;
  const auto& bounds_us = api::DurationHistogram::kBounds_us;
  std::uint64_t up_to = 0;
  for (std::size_t i = 0; i < counts.buckets.size(); ++i) {
    up_to += counts.buckets[i];
    histogram.bucket.push_back({up_to, i < bounds_us.size()
                                           ? static_cast<double>(bounds_us[i]) / 1e6
                                           : std::numeric_limits<double>::infinity()});
  }
}

std::string MetricsText::text() const { return prometheus::TextSerializer().Serialize(families_); }

}  // namespace aprsim::server
