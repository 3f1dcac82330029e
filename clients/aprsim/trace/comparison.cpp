#include "clients/aprsim/trace/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/trace/alignment.hpp"

namespace aprsim::trace {
namespace {

constexpr double kNotATolerance = 1e7;  // difference beyond any tolerance
constexpr std::size_t kNearBy = 40;     // search range for a moved command
constexpr double kMoved_mm = 200;       // an object seen farther away is another one
constexpr unsigned kLeastChange = 4, kWorstChange = 9;  // costs, beside kGapCost

/// A time span in a run's own time.
struct Span {
  double start_s = 0, end_s = 0;
};

/// Noun for an action of this wire.
const char* noun_of(v1::WireKind kind) {
  switch (kind) {
    case v1::WIRE_KIND_MODBUS:
      return "write";
    case v1::WIRE_KIND_GRPC:
    case v1::WIRE_KIND_WEB:
      return "call";
    case v1::WIRE_KIND_CRCL:
    case v1::WIRE_KIND_SIMPLE_MESSAGE:
      return "command";
    default:
      return "event";
  }
}

/// The robot of a CRCL wire; else the wire.
std::string who_of(const WireActions& wire) {
  return wire.name.starts_with("crcl.") ? wire.name.substr(5) : wire.name;
}

/// The worst difference of the fields of two actions of one kind; absent = equal.
std::optional<double> fields_differ(const Action& a, const Action& b, const Tolerance& tolerance) {
  double worst = a.fields.size() == b.fields.size() ? 0 : kNotATolerance;
  for (std::size_t i = 0; i < std::min(a.fields.size(), b.fields.size()); ++i) {
    if (a.fields[i].name != b.fields[i].name) {
      worst = kNotATolerance;
    } else if (const auto differs = difference(a.fields[i].value, b.fields[i].value, tolerance)) {
      worst = std::max(worst, differs->weight());
    }
  }
  return worst > 0 ? std::optional(worst) : std::nullopt;
}

bool are_same(const Action& a, const Action& b, const Tolerance& tolerance) {
  return a.kind == b.kind && !fields_differ(a, b, tolerance);
}

/// Pairs fields by name; a field may be in one action only.
void for_each_field(const std::vector<Field>& a, const std::vector<Field>& b, const auto& take) {
  std::set<std::string> names;
  const auto find = [](const std::vector<Field>& fields, const std::string& name) -> const Value* {
    const auto at = std::ranges::find(fields, name, &Field::name);
    return at == fields.end() ? nullptr : &at->value;
  };
  for (const auto* fields : {&a, &b}) {
    for (const Field& field : *fields) {
      if (names.insert(field.name).second) {
        take(field.name, find(a, field.name), find(b, field.name));
      }
    }
  }
}

/// Compares the actions of two runs on one wire.
class WireComparison {
 public:
  WireComparison(const WireActions& a, const WireActions& b, const Span& span_a, const Span& span_b,
                 const Tolerance& tolerance)
      : a_(a), b_(b), span_a_(span_a), span_b_(span_b), tolerance_(tolerance) {
    summary_ = {.name = a.name.empty() ? b.name : a.name,
                .actions_a = a.actions.size(),
                .actions_b = b.actions.size(),
                .polls_a = a.polls,
                .polls_b = b.polls};
  }

  std::pair<WireSummary, std::vector<Deviation>> run() {
    pairs_ = align(a_.actions.size(), b_.actions.size(),
                   [this](std::size_t i, std::size_t j) { return cost(i, j); });
    find_orders();
    for (std::size_t at = 0; at < pairs_.size(); ++at) compare_pair(at);
    compare_reads();
    compare_seen();
    summary_.deviations = out_.size();
    return {summary_, std::move(out_)};
  }

 private:
  [[nodiscard]] unsigned cost(std::size_t i, std::size_t j) const {
    const Action &a = a_.actions[i], &b = b_.actions[j];
    if (a.kind != b.kind) return kNeverPaired;
    const auto worst = fields_differ(a, b, tolerance_);
    if (!worst) return 0;
    // The more they differ, the likelier they are two commands.
    const double share = std::min(std::log10(1 + *worst) / 4, 1.0);
    return kLeastChange + static_cast<unsigned>(share * (kWorstChange - kLeastChange));
  }

  // ---- Moved commands.

  [[nodiscard]] bool is_same(std::size_t i, std::size_t j) const {
    return are_same(a_.actions[i], b_.actions[j], tolerance_);
  }

  /// Finds pairs whose commands were swapped with another pair.
  void find_orders() {
    std::vector<std::size_t> odd;  // positions with different commands
    for (std::size_t at = 0; at < pairs_.size(); ++at) {
      const AlignedPair& pair = pairs_[at];
      if (!pair.a || !pair.b || !is_same(*pair.a, *pair.b)) odd.push_back(at);
    }
    for (std::size_t k = 0; k < odd.size(); ++k) {
      for (std::size_t m = k + 1; m < odd.size() && odd[m] - odd[k] < kNearBy; ++m) {
        if (reported_.contains(odd[k]) || reported_.contains(odd[m])) continue;
        find_order(odd[k], odd[m]);
      }
    }
  }

  void find_order(std::size_t first, std::size_t second) {
    const AlignedPair &p = pairs_[first], &q = pairs_[second];
    if (p.a && p.b && q.a && q.b && is_same(*p.a, *q.b) && is_same(*q.a, *p.b)) {
      Deviation& out = add(DeviationKind::kOrder, p);
      out.text += fmt::format("and {} {} {} are in the other order", noun(), *q.a + 1,
                              a_.actions[*q.a].kind);
    } else if (p.a && !p.b && !q.a && q.b && is_same(*p.a, *q.b)) {
      Deviation& out = add(DeviationKind::kOrder, {p.a, q.b});
      out.text += fmt::format("comes later, as {} {}", noun(), *q.b + 1);
    } else if (!p.a && p.b && q.a && !q.b && is_same(*q.a, *p.b)) {
      Deviation& out = add(DeviationKind::kOrder, {q.a, p.b});
      out.text += fmt::format("comes earlier, as {} {}", noun(), *p.b + 1);
    } else {
      return;
    }
    reported_.insert(first);
    reported_.insert(second);
  }

  // ---- One pair.

  void compare_pair(std::size_t at) {
    if (reported_.contains(at)) return;
    const AlignedPair& pair = pairs_[at];
    if (!pair.b) {
      add(DeviationKind::kMissing, pair).text += "is missing" + content(a_.actions[*pair.a]);
      return;
    }
    if (!pair.a) {
      const Action& action = b_.actions[*pair.b];
      const bool again = *pair.b > 0 && are_same(b_.actions[*pair.b - 1], action, tolerance_);
      add(DeviationKind::kExtra, pair).text += (again ? "is repeated" : "is new") + content(action);
      return;
    }
    ++summary_.pairs;
    const Action &a = a_.actions[*pair.a], &b = b_.actions[*pair.b];
    const std::size_t before = out_.size();
    compare_fields(pair, a.fields, b.fields, DeviationKind::kValue, tolerance_, "");
    if (a.outcome != b.outcome && !a.outcome.empty() && !b.outcome.empty()) {
      Deviation& out = add(DeviationKind::kOutcome, pair);
      out.a = a.outcome;
      out.b = b.outcome;
      out.text +=
          fmt::format("ends with {}{}, was {}{}", b.outcome, in_words(b), a.outcome, in_words(a));
    }
    // A different request may have a different result.
    if (out_.size() != before) return;
    Tolerance ends = tolerance_;
    ends.position_mm = tolerance_.end_mm;
    ends.angle_deg = tolerance_.end_deg;
    compare_fields(pair, a.results, b.results, DeviationKind::kResult, ends, "ends with ");
    compare_times(pair, DeviationKind::kDuration, "takes", a.duration_s, b.duration_s);
    const bool in_turn =
        at > 0 && pairs_[at - 1].a && pairs_[at - 1].b && !reported_.contains(at - 1);
    if (in_turn) compare_times(pair, DeviationKind::kPause, "comes", a.pause_s, b.pause_s);
  }

  void compare_fields(const AlignedPair& pair, const std::vector<Field>& a,
                      const std::vector<Field>& b, DeviationKind kind, const Tolerance& tolerance,
                      const char* prefix) {
    for_each_field(a, b, [&](const std::string& name, const Value* x, const Value* y) {
      if (x == nullptr || y == nullptr) {
        // Different report settings do not count as a difference.
        if (kind == DeviationKind::kResult) return;
        Deviation& out = add(kind, pair);
        out.field = name;
        (x != nullptr ? out.a : out.b) = text_of(x != nullptr ? *x : *y);
        out.text += fmt::format("{} {} ({})", name, x != nullptr ? "is missing" : "is new",
                                text_of(x != nullptr ? *x : *y));
        return;
      }
      const auto differs = difference(*x, *y, tolerance);
      if (!differs) return;
      Deviation& out = add(kind, pair);
      out.field = name;
      out.a = text_of(*x);
      out.b = text_of(*y);
      if (!std::holds_alternative<std::string>(*x)) out.difference = differs;
      out.weight = differs->weight();
      out.text += prefix + difference_text(name, *x, *y);
    });
  }

  void compare_times(const AlignedPair& pair, DeviationKind kind, const char* verb,
                     std::optional<double> a, std::optional<double> b) {
    if (!a || !b) return;
    const double amount = std::abs(*b - *a);
    const double limit =
        std::max(tolerance_.time_s, 0.01 * tolerance_.time_percent * std::max(*a, *b));
    if (amount <= limit) return;
    Deviation& out = add(kind, pair);
    out.a = fmt::format("{:.3f} s", *a);
    out.b = fmt::format("{:.3f} s", *b);
    out.difference = Difference{amount, limit};
    out.weight = out.difference->weight();
    const char* how = kind == DeviationKind::kDuration ? (*b > *a ? "longer" : "shorter")
                                                       : (*b > *a ? "later" : "earlier");
    out.text += fmt::format("{} {:.2f} s {} ({}, was {}{})", verb, amount, how, out.b, out.a,
                            kind == DeviationKind::kPause ? ", after the previous action" : "");
  }

  // ---- Differences without a position.

  void compare_reads() {
    std::map<std::string, std::pair<std::size_t, std::size_t>> reads;
    for (const auto& [what, count] : a_.reads) reads[what].first = count;
    for (const auto& [what, count] : b_.reads) reads[what].second = count;
    for (const auto& [what, counts] : reads) {
      if (counts.first > 0 && counts.second > 0) continue;
      Deviation& out = add(DeviationKind::kRead, {});
      out.field = what;
      out.text += counts.second > 0
                      ? fmt::format("reads {}, {} times, which was never read", what, counts.second)
                      : fmt::format("never reads {}, which was read {} times", what, counts.first);
    }
  }

  void compare_seen() {
    // Pair each object with the nearest of its name; the rest is missing or new.
    std::vector<const Seen*> left;
    for (const Seen& seen : b_.seen) left.push_back(&seen);
    for (const Seen& seen : a_.seen) {
      const auto distance = [&](const Seen* other) {
        return other->name != seen.name
                   ? 1e9
                   : std::hypot(other->x_mm - seen.x_mm, other->y_mm - seen.y_mm);
      };
      const auto nearest = std::ranges::min_element(left, {}, distance);
      if (nearest == left.end() || distance(*nearest) > kMoved_mm) {
        add_seen(seen, "is not seen any more");
        continue;
      }
      compare_one_seen(seen, **nearest, distance(*nearest));
      left.erase(nearest);
    }
    for (const Seen* seen : left) add_seen(*seen, "is new");
  }

  void compare_one_seen(const Seen& a, const Seen& b, double distance_mm) {
    if (distance_mm > tolerance_.seen_mm) {
      Deviation& out = add_seen(a, fmt::format("lies {:.1f} mm elsewhere, at ({:.1f}, {:.1f}) mm",
                                               distance_mm, b.x_mm, b.y_mm));
      out.difference = Difference{1e-3 * distance_mm, 1e-3 * tolerance_.seen_mm};
      out.weight = out.difference->weight();
    }
    // A gear has no direction, and a tray looks the same after half a turn.
    if (a.type != "KT" && a.type != "PT") return;
    const double turn = std::abs(std::remainder(b.rotation_rad - a.rotation_rad, std::numbers::pi));
    const double limit = tolerance_.seen_deg * std::numbers::pi / 180;
    if (turn <= limit) return;
    Deviation& out =
        add_seen(a, fmt::format("is turned by {:.1f} deg", turn * 180 / std::numbers::pi));
    out.difference = Difference{turn, limit};
    out.weight = out.difference->weight();
  }

  Deviation& add_seen(const Seen& seen, const std::string& what) {
    Deviation& out = add(DeviationKind::kSeen, {});
    out.field = seen.name;
    out.text += fmt::format("in the end {} at ({:.1f}, {:.1f}) mm {}", seen.name, seen.x_mm,
                            seen.y_mm, what);
    return out;
  }

  // ---- Texts.

  [[nodiscard]] const char* noun() const {
    return noun_of(a_.kind == v1::WIRE_KIND_UNSPECIFIED ? b_.kind : a_.kind);
  }

  static std::string in_words(const Action& action) {
    return action.words.empty() ? "" : " (" + action.words + ")";
  }

  /// The fields of an action, if they are few.
  static std::string content(const Action& action) {
    std::string out;
    for (const Field& field : action.fields) {
      out += (out.empty() ? " (" : ", ") + field.name + " " + text_of(field.value);
      if (out.size() > 120) {
        out += ", ...";
        break;
      }
    }
    return out.empty() ? "" : out + ")";
  }

  /// Adds a deviation with its text. Deviations without a position come last.
  Deviation& add(DeviationKind kind, const AlignedPair& pair) {
    Deviation out{.kind = kind, .wire = summary_.name, .weight = kNotATolerance};
    const WireActions& wire = a_.name.empty() ? b_ : a_;
    out.text = who_of(wire);
    if (pair.a) out.number_a = *pair.a + 1;
    if (pair.b) out.number_b = *pair.b + 1;
    if (pair.a || pair.b) {
      const Action& action = pair.a ? a_.actions[*pair.a] : b_.actions[*pair.b];
      out.command = action.kind;
      out.time_s = action.time_s;
      out.since_start_s = action.time_s - (pair.a ? span_a_ : span_b_).start_s;
      out.text +=
          fmt::format(", {} {} {}", noun(), pair.a ? *pair.a + 1 : *pair.b + 1, action.kind);
      out.text += kind == DeviationKind::kOrder || kind == DeviationKind::kMissing ||
                          kind == DeviationKind::kExtra
                      ? " "
                      : ": ";
    } else {
      out.time_s = span_a_.end_s;
      out.since_start_s =
          std::max(span_a_.end_s - span_a_.start_s, span_b_.end_s - span_b_.start_s);
      out.text += ": ";
    }
    out_.push_back(std::move(out));
    return out_.back();
  }

  const WireActions &a_, &b_;
  const Span span_a_, span_b_;
  const Tolerance& tolerance_;
  WireSummary summary_;
  std::vector<AlignedPair> pairs_;
  std::set<std::size_t> reported_;  ///< positions already reported
  std::vector<Deviation> out_;
};

using Wires = std::map<std::string, WireActions>;

/// From the first command to the last.
Span span_of(const Wires& wires) {
  std::optional<Span> span;
  for (const auto& [name, wire] : wires) {
    if (wire.kind == v1::WIRE_KIND_UNSPECIFIED || wire.actions.empty()) continue;
    const double first = wire.actions.front().time_s, last = wire.actions.back().time_s;
    if (!span) span = Span{first, last};
    span = Span{std::min(span->start_s, first), std::max(span->end_s, last)};
  }
  return span.value_or(Span{});
}

/// Whether a network capture can contain such a wire.
bool is_essential(const WireActions& wire) {
  return wire.kind == v1::WIRE_KIND_CRCL || wire.kind == v1::WIRE_KIND_MODBUS;
}

bool has_any(const Wires& wires, v1::WireKind kind) {
  return std::ranges::any_of(wires, [&](const auto& one) { return one.second.kind == kind; });
}

/// Reports a listener without traffic in one run: a deviation, or a note if the recording has
/// none of its kind.
void note_lonely(const WireActions& wire, bool in_a, const Wires& others, double start,
                 Comparison& out) {
  if (wire.actions.empty() && wire.seen.empty()) return;
  const std::string what = fmt::format("{} has no traffic on {} ({} has {} {}{})", in_a ? "B" : "A",
                                       wire.name, in_a ? "A" : "B", wire.actions.size(),
                                       noun_of(wire.kind), wire.actions.size() == 1 ? "" : "s");
  if (!is_essential(wire) && !has_any(others, wire.kind)) {
    out.notes.push_back(what + "; not compared");
    return;
  }
  if (wire.actions.empty()) return;
  Deviation deviation{.kind = DeviationKind::kWire,
                      .wire = wire.name,
                      .time_s = wire.actions.front().time_s,
                      .weight = kNotATolerance,
                      .text = what};
  deviation.since_start_s = deviation.time_s - start;
  out.deviations.push_back(std::move(deviation));
}

}  // namespace

const char* word_of(DeviationKind kind) {
  switch (kind) {
    case DeviationKind::kMissing:
      return "missing";
    case DeviationKind::kExtra:
      return "extra";
    case DeviationKind::kOrder:
      return "order";
    case DeviationKind::kValue:
      return "value";
    case DeviationKind::kOutcome:
      return "outcome";
    case DeviationKind::kResult:
      return "result";
    case DeviationKind::kDuration:
      return "duration";
    case DeviationKind::kPause:
      return "pause";
    case DeviationKind::kRead:
      return "read";
    case DeviationKind::kSeen:
      return "seen";
    case DeviationKind::kWire:
      return "wire";
  }
  return "";
}

std::vector<const Deviation*> Comparison::worst(std::size_t count) const {
  std::vector<const Deviation*> out;
  for (const Deviation& deviation : deviations) out.push_back(&deviation);
  std::ranges::stable_sort(out, std::greater{}, &Deviation::weight);
  out.resize(std::min(out.size(), count));
  return out;
}

Comparison compare(const Trace& a, const Trace& b, const Tolerance& tolerance) {
  Comparison out;
  for (const auto& [which, trace] : {std::pair("A", &a), std::pair("B", &b)}) {
    for (const std::string& note : trace->notes)
      out.notes.push_back(fmt::format("{}: {}", which, note));
  }
  if (!a.header.scene_sha256().empty() && !b.header.scene_sha256().empty() &&
      a.header.scene_sha256() != b.header.scene_sha256()) {
    out.notes.push_back(
        fmt::format("the scenes differ: {} and {}", a.header.scene(), b.header.scene()));
  }
  const Wires wires_a = actions_of(a), wires_b = actions_of(b);
  const Span span_a = span_of(wires_a), span_b = span_of(wires_b);
  for (const auto& [name, wire] : wires_a) {
    const auto other = wires_b.find(name);
    if (other == wires_b.end()) {
      note_lonely(wire, true, wires_b, span_a.start_s, out);
      continue;
    }
    auto [summary, deviations] =
        WireComparison(wire, other->second, span_a, span_b, tolerance).run();
    out.wires.push_back(std::move(summary));
    std::ranges::move(deviations, std::back_inserter(out.deviations));
  }
  for (const auto& [name, wire] : wires_b) {
    if (!wires_a.contains(name)) note_lonely(wire, false, wires_a, span_b.start_s, out);
  }
  std::ranges::stable_sort(out.deviations, {}, &Deviation::since_start_s);
  return out;
}

}  // namespace aprsim::trace
