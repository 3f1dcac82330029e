#include "clients/aprsim/trace/comparison_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace aprsim::trace {
namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(std::optional<std::size_t> number) {
  return number ? Json(*number) : Json(nullptr);
}

Json deviation_json(const Deviation& deviation) {
  Json out{{"wire", deviation.wire},
           {"kind", word_of(deviation.kind)},
           {"command_a", number_or_null(deviation.number_a)},
           {"command_b", number_or_null(deviation.number_b)},
           {"command", deviation.command},
           {"time_s", deviation.time_s},
           {"field", deviation.field},
           {"a", deviation.a},
           {"b", deviation.b},
           {"difference", nullptr},
           {"tolerance", nullptr},
           {"times_tolerance", nullptr},
           {"text", deviation.text}};
  if (deviation.difference) {
    out["difference"] = deviation.difference->amount;
    out["tolerance"] = deviation.difference->limit;
    out["times_tolerance"] = deviation.difference->weight();
  }
  return out;
}

Json run_json(const Trace& trace) {
  return {{"place", trace.place},
          {"run_id", trace.header.run_id()},
          {"scene", trace.header.scene()},
          {"version", trace.header.version()}};
}

std::string line_of(const Deviation& deviation) {
  return fmt::format("{:10.3f} s  {}\n", deviation.time_s, deviation.text);
}

}  // namespace

std::string report_text(const Comparison& comparison, std::size_t most) {
  std::string out;
  std::size_t pairs = 0;
  for (const WireSummary& wire : comparison.wires) pairs += wire.pairs;
  if (comparison.same()) {
    out = fmt::format("the runs are the same within the tolerance: {} commands compared\n", pairs);
  } else {
    out = fmt::format("the runs differ: {} deviations, {} commands compared\nfirst:\n{}",
                      comparison.deviations.size(), pairs, line_of(comparison.deviations.front()));
    if (comparison.deviations.size() > 1) {
      out += "worst:\n";
      for (const Deviation* deviation : comparison.worst(most)) out += line_of(*deviation);
    }
  }
  out += "wires:\n";
  for (const WireSummary& wire : comparison.wires) {
    out += fmt::format(
        "  {:<20} {:>6} and {:<6} actions, {:>6} compared, {} deviations; polls {} and {}\n",
        wire.name, wire.actions_a, wire.actions_b, wire.pairs, wire.deviations, wire.polls_a,
        wire.polls_b);
  }
  for (const std::string& note : comparison.notes) out += "note: " + note + '\n';
  return out;
}

Json report_json(const Comparison& comparison, const Trace& a, const Trace& b,
                 const Tolerance& tolerance) {
  Json limits, wires = Json::array(), deviations = Json::array(), worst = Json::array();
  for (const ToleranceName& name : tolerance_names()) limits[name.name] = tolerance.*name.place;
  for (const WireSummary& wire : comparison.wires) {
    wires.push_back({{"name", wire.name},
                     {"actions_a", wire.actions_a},
                     {"actions_b", wire.actions_b},
                     {"compared", wire.pairs},
                     {"deviations", wire.deviations},
                     {"polls_a", wire.polls_a},
                     {"polls_b", wire.polls_b}});
  }
  for (const Deviation& deviation : comparison.deviations) {
    deviations.push_back(deviation_json(deviation));
  }
  for (const Deviation* deviation : comparison.worst(10))
    worst.push_back(deviation_json(*deviation));
  return {{"same", comparison.same()},
          {"a", run_json(a)},
          {"b", run_json(b)},
          {"tolerance", limits},
          {"first", comparison.same() ? Json(nullptr) : deviations.front()},
          {"worst", worst},
          {"wires", wires},
          {"notes", comparison.notes},
          {"deviations", deviations}};
}

}  // namespace aprsim::trace
