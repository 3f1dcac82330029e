#include "world/scenario/scenario_reader.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <set>

#include "world/api/faults/fault_kinds.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scenario/measure_kinds.hpp"
#include "world/scenario/scenario_check.hpp"
#include "world/scenario/scene_change.hpp"
#include "world/scene/readers/reading.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::scenario {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest = 1e6;  // limit of all times [s]
constexpr yaml::Range kTime{.min = 0, .max = kLongest};
constexpr yaml::Range kSpan{.min = 0, .max = kLongest, .open_min = true};
constexpr yaml::Range kShare{.min = 0, .max = 0.9};

constexpr std::array<std::string_view, 14> kKeys = {
    "description", "scene",           "cell", "program", "controller", "remove", "supply", "orders",
    "faults",      "kill_controller", "vary", "stop",    "expect",     "scoring"};

/// Options of the controllers that scenarios from outside may have: they concern no files.
constexpr std::array<std::string_view, 4> kSentOptions = {"--robots", "--patience", "--wires",
                                                          "--no-belt"};

/// Controllers in clients/kitting.
constexpr std::array<std::string_view, 2> kPrograms = {"kitting", "pick"};

bool is_file(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml");
}

}  // namespace

Result<std::string> find_scenario(const std::string& name_or_file, const scene::DataPaths& paths) {
  if (is_file(name_or_file)) return name_or_file;
  const fs::path path = fs::path(paths.scenarios) / (name_or_file + ".yaml");
  std::error_code status;
  if (!name_or_file.empty() && fs::is_regular_file(path, status)) return path.string();
  const auto names = scene::names_in(paths.scenarios);
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  const std::string near = yaml::nearest_word(name_or_file, names);
  return fail(ErrorCode::kNotFound, "scenario",
              "scenario: found no scenario \"" + name_or_file + "\", expected one of " +
                  (list.empty() ? "(there is none)" : list) +
                  (near.empty() ? "" : " (did you mean " + near + "?)"));
}

namespace {

/// The path of the scene that a scenario names.
Result<std::string> scene_of(const std::string& name, const std::string& scenario,
                             const scene::DataPaths& paths) {
  const bool beside = is_file(name) && !fs::path(name).is_absolute();
  return scene::find_scene(beside ? (fs::path(scenario).parent_path() / name).string() : name,
                           paths);
}

std::optional<double> read_optional(const yaml::Node& node, const yaml::Range& range) {
  return node ? std::optional(node.number(range)) : std::nullopt;
}

/// [MIN, MAX] in rising order.
std::array<double, 2> read_interval(const yaml::Node& node, const yaml::Range& range) {
  const auto ends = node.numbers<2>(range);
  if (ends[0] > ends[1]) node.unexpected("two numbers in rising order");
  return ends;
}

/// "placed:N", "submitted:ORDER" or "fault:NAME".
Moment read_event(const yaml::Node& node) {
  const std::string text = node.text();
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string what = text.substr(0, colon);
  const std::string rest = text.substr(std::min(colon + 1, text.size()));
  if (what == "submitted" && !rest.empty()) return OnSubmitted{rest};
  if (what == "fault" && !rest.empty()) return OnFault{rest};
  OnPlaced placed;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), placed.count);
  if (what != "placed" || error != std::errc() || end != rest.data() + rest.size() ||
      placed.count == 0) {
    node.unexpected("placed:N, submitted:ORDER or fault:NAME");
  }
  return placed;
}

/// Reads the keys at_s and when; at most one may be present.
Moment read_moment(const yaml::Map& keys) {
  if (keys["at_s"] && keys["when"]) keys["when"].error("both at_s and when", "one of them");
  if (keys["when"]) return read_event(keys["when"]);
  return keys["at_s"].number_or(0, kTime);
}

std::vector<std::string> names_of_measures() {
  std::vector<std::string> names;
  for (const auto& kind : measure_kinds()) names.emplace_back(kind.name);
  return names;
}

std::vector<std::string> names_of_kinds() {
  std::vector<std::string> names;
  for (const auto& kind : faults::all_kinds()) names.emplace_back(kind.name);
  return names;
}

class Reader {
 public:
  /// With `collects`, reading goes on after errors that leave a scene. `scope`: of a scenario from
  /// outside.
  Reader(yaml::Document& document, std::string file, const scene::DataPaths& paths,
         bool collects = false, const SentScope* scope = nullptr)
      : document_(document), paths_(paths), collects_(collects), scope_(scope) {
    out_.file = std::move(file);
    out_.name = fs::path(out_.file).stem().string();
  }

  Result<Scenario> read() {
    const yaml::Map keys = document_.root().map(kKeys);
    out_.description = keys["description"].text();
    if (out_.description.find('\n') != std::string::npos) {
      keys["description"].unexpected("one line");
    }
    if (auto ok = read_scene(keys); !ok) return tl::unexpected(std::move(ok.error()));
    if (document_.error() && !collects_) return tl::unexpected(*document_.error());
    read_names(keys);
    for (const yaml::Node& node : keys["orders"].items()) read_order(node);
    if (!keys["orders"]) keys["orders"].unexpected("a list of orders");
    check_counts(keys["orders"], out_);
    for (const yaml::Node& node : keys["faults"].items()) read_fault(node);
    check_moments(keys);
    for (const yaml::Node& node : keys["kill_controller"].items()) read_kill(node);
    read_variation(keys["vary"]);
    read_stop(keys["stop"]);
    read_expected(keys["expect"]);
    read_scoring(keys["scoring"]);
    if (document_.error()) return tl::unexpected(*document_.error());
    return std::move(out_);
  }

 private:
  /// The underlying scene, valid and with the types that it names.
  Result<Tree> base_scene(const yaml::Node& node) {
    const std::string name = node.text();
    if (document_.is_recorded()) return Tree{.kind = Tree::Kind::kMap};
    if (document_.error() && name.empty()) return tl::unexpected(*document_.error());
    if (scope_ != nullptr && is_file(name) && name != scope_->own_scene) {
      node.unexpected("a shipped scene, or the daemon's: " + scope_->own_scene);
      return tl::unexpected(*document_.error());
    }
    const auto file = scene_of(name, out_.file, paths_);
    if (!file) return tl::unexpected(refer(node, file.error()));
    out_.scene_file = *file;
    // Errors in the scene itself name the scene's own file.
    if (auto base = scene::load_scene(*file, paths_); !base) {
      return tl::unexpected(refer(node, base.error()));
    }
    auto text = scene::self_contained(*file, paths_);
    if (!text) return tl::unexpected(std::move(text.error()));
    return yaml::detail::parse(*text, *file);
  }

  /// Reads the underlying scene and applies `remove` and `supply`.
  Result<void> read_scene(const yaml::Map& keys) {
    auto tree = base_scene(keys["scene"]);
    if (!tree) return tl::unexpected(std::move(tree.error()));
    out_.changes_parts = keys["remove"] || keys["supply"];
    for (const yaml::Node& node : keys["remove"].items()) {
      const std::string body = node.text();
      if (!remove_body(*tree, body)) node.unexpected("the name of a tray or gear in the scene");
    }
    for (const yaml::Node& node : keys["supply"].items()) add_tray(node, *tree);
    if (document_.is_recorded()) return {};
    if (document_.error() && !collects_) return tl::unexpected(*document_.error());
    out_.scene_text = yaml::detail::write(*tree);
    auto changed = scene::read_scene(out_.scene_text, out_.scene_file, paths_);
    if (!changed) {
      return tl::unexpected(
          refer(keys["supply"] ? keys["supply"] : keys["remove"], changed.error()));
    }
    out_.scene = std::move(*changed);
    return {};
  }

  [[nodiscard]] Error refer(const yaml::Node& node, const Error& error) const {
    node.error("an invalid scene (" + error.message + ")", "a valid one", error.code);
    return *document_.error();
  }

  /// A part tray on the belt, full by default.
  void add_tray(const yaml::Node& node, Tree& tree) {
    const yaml::Map keys = node.map({"name", "type", "on", "xy_m", "yaw_deg", "gears"});
    Tree tray{.kind = Tree::Kind::kMap};
    const auto word = [](std::string text) {
      return Tree{.kind = Tree::Kind::kScalar, .scalar = std::move(text)};
    };
    const std::string name = scene::read_name(keys["name"]);
    const std::string type = keys["type"].text();
    child(tray, "name") = word(name);
    child(tray, "type") = word(type);
    child(tray, "on") = word(keys["on"].text_or("conveyor"));
    const auto xy = keys["xy_m"].numbers<2>(yaml::between(-scene::kFar, scene::kFar));
    child(tray, "xy_m") = yaml::detail::list({xy[0], xy[1]});
    if (keys["yaw_deg"]) {
      child(tray, "yaw_deg") =
          yaml::detail::scalar(keys["yaw_deg"].number(yaml::between(-360, 360)));
    }
    const auto slots = slots_of(tree, type);
    if (slots.empty()) keys["type"].unexpected("a type of tray in the scene");
    std::set<std::string> filled(slots.begin(), slots.end());
    if (keys["gears"]) {
      filled.clear();
      for (const yaml::Node& slot : keys["gears"].items()) {
        const std::string slot_name = slot.text();
        if (std::ranges::find(slots, slot_name) == slots.end()) {
          scene::report_unknown(slot, slot_name, "slot", slots);
        }
        filled.insert(slot_name);
      }
    }
    Tree gears{.kind = Tree::Kind::kMap};
    for (const std::string& slot : filled) child(gears, slot) = word(name + '_' + slot);
    if (!gears.entries.empty()) child(tray, "gears") = std::move(gears);
    Tree& trays = child(tree, "trays");
    trays.kind = Tree::Kind::kList;
    trays.items.push_back(std::move(tray));
  }

  static std::vector<std::string> slots_of(const Tree& tree, const std::string& type) {
    std::vector<std::string> out;
    const yaml::detail::Entry* types = tree.find("tray_types");
    const yaml::detail::Entry* found = types == nullptr ? nullptr : types->value.find(type);
    const yaml::detail::Entry* slots = found == nullptr ? nullptr : found->value.find("slots");
    if (slots == nullptr) return out;
    for (const Tree& slot : slots->value.items) {
      if (const auto* name = slot.find("name")) out.push_back(name->value.scalar);
    }
    return out;
  }

  void check_sent_names(const yaml::Map& keys) const {
    if (keys["cell"] && out_.cell.find_first_of("./") != std::string::npos) {
      keys["cell"].unexpected("the name of a cell, not a file");
    }
    for (const yaml::Node& option : keys["controller"].items()) {
      const std::string word = option.text();
      if (word.starts_with('-') && std::ranges::find(kSentOptions, word) == kSentOptions.end()) {
        option.unexpected("--robots, --patience, --wires or --no-belt in a scenario from a page");
      }
    }
  }

  void read_names(const yaml::Map& keys) {
    out_.cell = keys["cell"].text_or(fs::path(out_.scene_file).stem().string());
    if (scope_ != nullptr) check_sent_names(keys);
    if (const auto program = keys["program"]) {
      program.note_words(std::vector<std::string>(kPrograms.begin(), kPrograms.end()));
      out_.program = program.text();
      if (std::ranges::find(kPrograms, out_.program) == std::end(kPrograms)) {
        program.unexpected("kitting or pick");
      }
    }
    for (const yaml::Node& option : keys["controller"].items()) {
      out_.controller_options.push_back(option.text());
    }
  }

  void read_order(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "tray", "slots", "count", "priority", "deadline_s",
                                     "at_s", "when", "cancel", "destination"});
    Order order;
    order.name = scene::read_name(keys["name"]);
    if (std::ranges::find(out_.orders, order.name, &Order::name) != out_.orders.end()) {
      keys["name"].error("a second order " + order.name, "unique names");
    }
    order.tray = keys["tray"].text();
    for (const auto& [slot, part] : keys["slots"].entries()) order.slots[slot] = part.text();
    if (keys["slots"] && order.slots.empty()) keys["slots"].unexpected("a slot and its part");
    check_order(keys, order, out_.scene);
    const auto type = out_.scene.tray_types.find(order.tray);
    if (order.slots.empty() && type != out_.scene.tray_types.end()) {
      for (const scene::Slot& slot : type->second.slots) order.slots[slot.name] = slot.gear_type;
    }
    order.count = static_cast<unsigned>(keys["count"].integer_or(1, 1, 1000));
    order.priority = static_cast<int>(keys["priority"].integer_or(0, 0, 1000));
    order.deadline_s = read_optional(keys["deadline_s"], kSpan);
    order.announced = read_moment(keys);
    if (keys["cancel"]) order.cancelled = read_moment(keys["cancel"].map({"at_s", "when"}));
    if (keys["destination"]) {
      const yaml::Map area = keys["destination"].map({"min_m", "max_m"});
      const auto range = yaml::between(-scene::kFar, scene::kFar);
      order.destination = {area["min_m"].numbers<2>(range), area["max_m"].numbers<2>(range)};
    }
    out_.orders.push_back(std::move(order));
  }

  void read_fault(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "kind", "target", "with", "at_s", "when", "for_s"});
    Fault fault;
    if (keys["name"]) fault.name = scene::read_name(keys["name"]);
    keys["kind"].note_words(names_of_kinds());
    fault.kind = keys["kind"].text();
    if (keys["target"]) fault.target = keys["target"].text();
    check_fault(keys, fault, out_.scene);
    for (const auto& [name, value] : keys["with"].entries()) {
      fault.parameters[name] = value.number();
    }
    if (keys["at_s"]) fault.at_s = read_times(keys["at_s"]);
    if (keys["when"]) read_when(keys, fault);
    fault.for_s = read_optional(keys["for_s"], kSpan);
    out_.faults.push_back(std::move(fault));
  }

  /// A time, or a range from which it is drawn.
  static std::array<double, 2> read_times(const yaml::Node& node) {
    if (node.is_list()) return read_interval(node, kTime);
    const double at_s = node.number(kTime);
    return {at_s, at_s};
  }

  void read_kill(const yaml::Node& node) {
    out_.kills_s.push_back(read_times(node.map({"at_s"})["at_s"]));
  }

  void read_when(const yaml::Map& keys, Fault& fault) const {
    if (fault.at_s) keys["when"].error("both at_s and when", "one of them");
    auto when = faults::parse_when(keys["when"].text());
    if (!when) {
      keys["when"].unexpected(
          "placed:TYPE[:ROBOT], grasp:ROBOT[:N], beam:EYE, event:NAME or QUANTITY[:ROBOT[:JOINT]] "
          "with > or < and a limit");
      return;
    }
    check_when(keys["when"], *when, out_);
    fault.when = *std::move(when);
  }

  /// Call after all orders and faults are read.
  void check_moments(const yaml::Map& keys) const {
    const auto nodes = keys["orders"].items();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const yaml::Map order = nodes[i].map({"name", "tray", "slots", "count", "priority",
                                            "deadline_s", "at_s", "when", "cancel", "destination"});
      check_moment(order["when"], out_.orders[i].announced, out_);
      if (!out_.orders[i].cancelled) continue;
      check_moment(order["cancel"].map({"at_s", "when"})["when"], *out_.orders[i].cancelled, out_);
    }
  }

  void read_variation(const yaml::Node& node) {
    if (!node) return;
    const yaml::Map keys =
        node.map({"tray_xy_m", "tray_yaw_deg", "gear_yaw_deg", "friction", "gear_mass",
                  "vision_position_noise_m", "vision_rotation_noise_deg"});
    Variation& vary = out_.variation;
    vary.tray_xy_m = keys["tray_xy_m"].number_or(0, yaml::between(0, 1));
    vary.tray_yaw_rad = scene::radians(keys["tray_yaw_deg"].number_or(0, yaml::between(0, 180)));
    vary.gear_yaw_rad = scene::radians(keys["gear_yaw_deg"].number_or(0, yaml::between(0, 180)));
    vary.friction = keys["friction"].number_or(0, kShare);
    vary.gear_mass = keys["gear_mass"].number_or(0, kShare);
    if (const auto noise = keys["vision_position_noise_m"]) {
      vary.vision_position_noise_m = read_interval(noise, yaml::between(0, 0.1));
    }
    if (const auto noise = keys["vision_rotation_noise_deg"]) {
      const auto ends_deg = read_interval(noise, yaml::between(0, 45));
      vary.vision_rotation_noise_rad = {scene::radians(ends_deg[0]), scene::radians(ends_deg[1])};
    }
  }

  void read_stop(const yaml::Node& node) {
    if (!node) return;
    const yaml::Map keys = node.map({"time_limit_s", "orders_submitted", "quiet_s"});
    out_.stop.time_limit_s = keys["time_limit_s"].number_or(out_.stop.time_limit_s, kSpan);
    out_.stop.orders_submitted = keys["orders_submitted"].boolean_or(true);
    out_.stop.quiet_s = read_optional(keys["quiet_s"], kSpan);
  }

  void read_expected(const yaml::Node& node) {
    node.note_names(names_of_measures());
    for (const auto& [name, bound] : node.entries()) {
      if (find_measure(name) == nullptr) {
        scene::report_unknown(bound, name, "measure", names_of_measures());
        continue;
      }
      Bound& out = out_.expected[name];
      if (!bound.is_map()) {
        out.min = out.max = bound.number();
        continue;
      }
      const yaml::Map keys = bound.map({"min", "max"});
      out = {read_optional(keys["min"], {}), read_optional(keys["max"], {})};
      if (!out.min && !out.max) bound.unexpected("min, max or both");
      if (out.min && out.max && *out.min > *out.max) keys["max"].unexpected("at least min");
    }
  }

  void read_scoring(const yaml::Node& node) {
    if (!node) return;
    const yaml::Map keys = node.map({"slot", "tray", "priority", "collision", "collision_again_s",
                                     "invalid_surface", "baseline_s", "baseline_score"});
    Scoring& scoring = out_.scoring;
    scoring.slot = keys["slot"].number_or(scoring.slot, yaml::kNotNegative);
    scoring.tray = keys["tray"].number_or(scoring.tray, yaml::kNotNegative);
    scoring.priority = keys["priority"].number_or(scoring.priority, yaml::kNotNegative);
    scoring.collision = keys["collision"].number_or(scoring.collision, yaml::kNotNegative);
    scoring.collision_again_s =
        keys["collision_again_s"].number_or(scoring.collision_again_s, kSpan);
    scoring.invalid_surface =
        keys["invalid_surface"].number_or(scoring.invalid_surface, yaml::kNotNegative);
    scoring.baseline_s = read_optional(keys["baseline_s"], kSpan);
    scoring.baseline_score = read_optional(keys["baseline_score"], yaml::kPositive);
  }

  yaml::Document& document_;
  const scene::DataPaths& paths_;
  bool collects_;
  const SentScope* scope_;
  Scenario out_;
};

}  // namespace

Result<Scenario> load_scenario(const std::string& name_or_file, const scene::DataPaths& paths) {
  auto file = find_scenario(name_or_file, paths);
  if (!file) return tl::unexpected(std::move(file.error()));
  auto document = yaml::Document::from_file(*file);
  if (!document) return tl::unexpected(std::move(document.error()));
  return Reader(*document, std::move(*file), paths).read();
}

std::vector<Error> examine_scenario(const std::string& text, const std::string& file,
                                    const scene::DataPaths& paths) {
  auto document = yaml::Document::from_text(text, file);
  if (!document) return {std::move(document.error())};
  document->collect_errors();
  const auto scenario = Reader(*document, file, paths, true).read();
  if (!scenario && document->errors().empty()) return {scenario.error()};
  return document->errors();
}

ExaminedScenario examine_sent_scenario(const std::string& text, const SentScope& scope,
                                       const scene::DataPaths& paths) {
  constexpr const char* kFile = "scenario text";
  auto document = yaml::Document::from_text(text, kFile);
  if (!document) return {{std::move(document.error())}, std::nullopt};
  document->collect_errors();
  auto scenario = Reader(*document, kFile, paths, true, &scope).read();
  if (scenario) return {{}, std::move(*scenario)};
  if (document->errors().empty()) return {{scenario.error()}, std::nullopt};
  return {document->errors(), std::nullopt};
}

yaml::KeySchema scenario_keys() {
  constexpr int kRuns = 400;
  yaml::KeyRecorder recorder;
  auto document = yaml::Document::recorded(recorder);
  for (int run = 0; run < kRuns; ++run) {
    recorder.begin_run();
    static_cast<void>(Reader(document, "recorded", {}).read());
    recorder.end_run();
  }
  return recorder.schema();
}

Result<Summary> summarize_scenario(const std::string& name, const scene::DataPaths& paths) {
  const auto file = find_scenario(name, paths);
  if (!file) return tl::unexpected(file.error());
  const auto document = yaml::Document::from_file(*file);
  if (!document) return tl::unexpected(document.error());
  const yaml::Map keys = document->root().map(kKeys);
  Summary out{.description = keys["description"].text(),
              .scene_file = keys["scene"].text(),
              .changes_parts = keys["remove"] || keys["supply"]};
  if (document->error()) return tl::unexpected(*document->error());
  auto scene = scene_of(out.scene_file, *file, paths);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  out.scene_file = std::move(*scene);
  return out;
}

}  // namespace aprsim::scenario
