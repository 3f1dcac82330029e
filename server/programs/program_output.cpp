#include "server/programs/program_output.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "protocols/net/limited_log.hpp"

namespace aprsim::server {
namespace {

using Json = nlohmann::json;

std::string text_in(const Json& object, const char* key, std::size_t limit = kLongestText) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string()) return {};
  return protocols::log_text(found->get_ref<const std::string&>(), limit);
}

double number_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return 0;
  const double value = found->get<double>();
  return std::isfinite(value) ? value : 0;
}

std::uint32_t count_in(const Json& object, const char* key) {
  const double value = number_in(object, key);
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  return value >= 0 && value <= kMost ? static_cast<std::uint32_t>(value) : 0;
}

void take_progress(const Json& progress, web::ProgramStatus& status) {
  status.time_s = number_in(progress, "time_s");
  status.placed = count_in(progress, "placed");
  status.orders.clear();
  const auto orders = progress.find("orders");
  if (orders == progress.end() || !orders->is_array()) return;
  for (const Json& order : *orders) {
    if (!order.is_object() || status.orders.size() >= kMostOrders) continue;
    status.orders.push_back({.name = text_in(order, "name"),
                             .tray = text_in(order, "tray"),
                             .state = text_in(order, "state"),
                             .kits = count_in(order, "kits"),
                             .done = count_in(order, "done"),
                             .parts = count_in(order, "parts"),
                             .parts_wanted = count_in(order, "parts_wanted")});
  }
}

void add_line(std::string line, web::ProgramStatus& status) {
  if (status.lines.size() >= kMostLines) status.lines.erase(status.lines.begin());
  status.lines.push_back(std::move(line));
}

/// A table with its line ends, without other control characters.
std::string table_in(const Json& object) {
  const auto found = object.find("report");
  if (found == object.end() || !found->is_string()) return {};
  std::string out, line;
  const auto end_line = [&] {
    out += protocols::log_text(line) + '\n';
    line.clear();
  };
  for (const char c : found->get_ref<const std::string&>()) {
    if (out.size() + line.size() > kLongestReport) break;
    if (c == '\n') {
      end_line();
    } else {
      line += c;
    }
  }
  if (!line.empty()) end_line();
  return out;
}

}  // namespace

std::optional<std::string> take_line(std::string_view line, web::ProgramStatus& status) {
  const Json object = Json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) {
    std::string text = protocols::log_text(line, kLongestText);
    add_line(text, status);
    return text;
  }
  const auto progress = object.find("progress");
  if (progress != object.end() && progress->is_object()) take_progress(*progress, status);
  if (object.contains("report")) status.report = table_in(object);
  if (const std::string event = text_in(object, "event"); !event.empty()) {
    add_line(fmt::format("{:.2f} s: {}", number_in(object, "time_s"), event), status);
  }
  if (const std::string text = text_in(object, "text"); !text.empty()) {
    const std::string source = text_in(object, "source");
    add_line(source.empty() ? text : source + ": " + text, status);
  }
  return std::nullopt;
}

}  // namespace aprsim::server
