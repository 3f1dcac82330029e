#include "server/metrics_text.hpp"

#include <cmath>

#include <fmt/format.h>

namespace aprsim::server {
namespace {

/// Of a label's value: backslash, quote and line end.
std::string escaped(std::string_view value) {
  std::string out;
  for (const char c : value) {
    if (c == '\\' || c == '"') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out;
}

std::string text_of(double value) {
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return std::isnan(value) ? "NaN" : fmt::format("{}", value);
}

}  // namespace

void MetricsText::metric(std::string_view name, std::string_view type, std::string_view help) {
  name_ = name;
  text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
}

void MetricsText::line(std::string_view suffix, const Labels& labels, std::string_view value) {
  text_ += name_;
  text_ += suffix;
  char before = '{';
  for (const auto& [label, label_value] : labels) {
    text_ += fmt::format("{}{}=\"{}\"", before, label, escaped(label_value));
    before = ',';
  }
  if (!labels.empty()) text_ += '}';
  text_ += fmt::format(" {}\n", value);
}

void MetricsText::sample(double value, const Labels& labels) { line("", labels, text_of(value)); }

void MetricsText::sample(std::uint64_t value, const Labels& labels) {
  line("", labels, std::to_string(value));
}

void MetricsText::histogram(const api::DurationHistogram::Counts& counts, const Labels& labels) {
  std::uint64_t up_to = 0;
  Labels all = labels;
  all.emplace_back("le", "");
  for (std::size_t i = 0; i < counts.buckets.size(); ++i) {
    up_to += counts.buckets[i];
    const auto& bounds = api::DurationHistogram::kBounds_us;
    all.back().second = i < bounds.size() ? text_of(static_cast<double>(bounds[i]) / 1e6) : "+Inf";
    line("_bucket", all, std::to_string(up_to));
  }
  line("_sum", labels, text_of(counts.sum_s));
  line("_count", labels, std::to_string(counts.count));
}

}  // namespace aprsim::server
