// The arrows of ARCHITECTURE.md, checked against every #include of ours.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

/// The rooms, one a folder, and the rooms that each includes. A room includes all of its row and
/// nothing else.
const std::map<std::string, std::set<std::string>> kArrows = {
    {"clients/aprsim",
     {"clients/aprsim/cli", "clients/aprsim/commands", "world/base", "world/base/process"}},
    {"clients/aprsim/batch",
     {"clients/aprsim/cli", "clients/aprsim/scenario", "clients/wires", "world/base",
      "world/base/files", "world/scenario"}},
    {"clients/aprsim/cli",
     {"clients/aprsim/text", "clients/wires", "world/base", "world/base/process"}},
    {"clients/aprsim/commands",
     {"clients/aprsim/batch", "clients/aprsim/cli", "clients/aprsim/conform", "clients/aprsim/demo",
      "clients/aprsim/files", "clients/aprsim/scenario", "clients/aprsim/text",
      "clients/aprsim/trace", "clients/wires", "crcl", "modbus", "proto/aprsim/v1",
      "world/api/faults", "world/base/files", "world/base/process", "world/base/usage",
      "world/scenario"}},
    {"clients/aprsim/conform", {"clients/aprsim/cli", "clients/wires", "crcl", "modbus"}},
    {"clients/aprsim/demo",
     {"clients/aprsim/cli", "clients/wires", "crcl", "modbus", "proto/aprsim/v1"}},
    {"clients/aprsim/files",
     {"clients/wires", "world/base/yaml", "world/robot/kinematics/choice", "world/robot/model",
      "world/scenario", "world/scene", "world/scene/model"}},
    {"clients/aprsim/scenario",
     {"clients/aprsim/cli", "clients/aprsim/demo", "clients/aprsim/text", "clients/wires",
      "proto/aprsim/v1", "world/base", "world/base/files", "world/base/process", "world/scenario"}},
    {"clients/aprsim/text",
     {"clients/wires", "crcl", "proto/aprsim/v1", "world/api/faults", "world/api/signals"}},
    {"clients/aprsim/trace",
     {"clients/aprsim/cli", "clients/wires", "crcl", "modbus", "proto/aprsim/v1", "proto/journal",
      "protocols/simple_message/codec", "world/base", "world/base/files", "world/base/process"}},
    {"clients/devices", {}},
    {"clients/examples", {"clients/wires"}},
    {"clients/ros2",
     {"clients/ros2/cameras", "clients/ros2/cell", "clients/ros2/dds", "clients/ros2/simulation",
      "clients/ros2/trajectory", "clients/wires", "proto/aprsim/v1", "world/base/usage"}},
    {"clients/ros2/actions", {}},
    {"clients/ros2/cameras",
     {"clients/ros2/cell", "clients/ros2/dds", "clients/ros2/trays", "clients/wires",
      "proto/aprsim/v1"}},
    {"clients/ros2/cell", {"proto/aprsim/v1"}},
    {"clients/ros2/dds",
     {"clients/ros2/actions", "clients/ros2/cell", "clients/ros2/simulation",
      "clients/ros2/trajectory", "clients/ros2/trays", "proto/aprsim/v1"}},
    {"clients/ros2/simulation", {"clients/ros2/actions", "clients/wires", "proto/aprsim/v1"}},
    {"clients/ros2/trajectory", {"clients/ros2/actions", "clients/wires", "proto/aprsim/v1"}},
    {"clients/ros2/trays", {"clients/ros2/cell", "proto/aprsim/v1"}},
    {"clients/wires", {"crcl", "modbus", "proto/aprsim/v1", "world/base"}},
    {"crcl", {"proto/aprsim/crcl/v1"}},
    {"modbus", {}},
    {"proto/journal", {"proto/aprsim/v1", "world/base"}},
    {"protocols/access", {"world/api/ports", "world/base"}},
    {"protocols/cameras", {"protocols/net", "protocols/ports", "world/base"}},
    {"protocols/conveyor", {"modbus", "world/api/commands", "world/api/ports", "world/base"}},
    {"protocols/crcl",
     {"crcl", "protocols/net", "protocols/ports", "protocols/record", "world/api/commands",
      "world/api/description", "world/api/ports", "world/api/snapshot", "world/api/values",
      "world/base"}},
    {"protocols/grpc",
     {"protocols/grpc/calls", "protocols/grpc/http2", "protocols/grpc/services",
      "protocols/grpc/streams", "protocols/net", "world/api/ports", "world/base"}},
    {"protocols/grpc/calls",
     {"protocols/access", "protocols/messages", "protocols/net", "protocols/ports",
      "protocols/record", "world/api/ports", "world/api/values", "world/base"}},
    {"protocols/grpc/http2",
     {"protocols/grpc/calls", "protocols/net", "protocols/record", "world/base"}},
    {"protocols/grpc/services",
     {"crcl", "proto/aprsim/crcl/v1", "proto/aprsim/v1", "protocols/grpc/calls",
      "protocols/grpc/streams", "protocols/messages", "protocols/ports", "world/api/commands",
      "world/api/ports", "world/base"}},
    {"protocols/grpc/streams",
     {"proto/aprsim/v1", "protocols/grpc/calls", "protocols/messages", "protocols/ports",
      "world/api/description", "world/api/ports", "world/api/snapshot", "world/api/values"}},
    {"protocols/messages",
     {"proto/aprsim/v1", "world/api/commands", "world/api/description", "world/api/faults",
      "world/api/ports", "world/api/snapshot", "world/api/values", "world/base"}},
    {"protocols/modbus",
     {"modbus", "protocols/modbus/banks", "protocols/modbus/security", "protocols/net",
      "protocols/ports", "protocols/record", "world/api/ports", "world/api/snapshot",
      "world/base"}},
    {"protocols/modbus/banks",
     {"modbus", "protocols/conveyor", "world/api/commands", "world/api/ports",
      "world/api/signals"}},
    {"protocols/modbus/security", {"modbus", "protocols/access", "protocols/net", "world/base"}},
    {"protocols/net", {"protocols/access", "protocols/ports", "world/api/ports", "world/base"}},
    {"protocols/ports",
     {"crcl", "world/api/description", "world/api/snapshot", "world/api/values", "world/base"}},
    {"protocols/record",
     {"protocols/access", "protocols/net", "protocols/ports", "world/api/ports"}},
    {"protocols/simple_message",
     {"protocols/net", "protocols/ports", "protocols/record", "protocols/simple_message/codec",
      "world/api/ports", "world/api/snapshot", "world/base"}},
    {"protocols/simple_message/codec", {"world/base"}},
    {"protocols/vision",
     {"protocols/net", "protocols/ports", "protocols/record", "world/api/description",
      "world/api/ports", "world/api/snapshot", "world/base"}},
    {"protocols/web",
     {"protocols/net", "protocols/web/http", "protocols/web/viewer", "world/api/ports",
      "world/base"}},
    {"protocols/web/http",
     {"proto/aprsim/v1", "protocols/access", "protocols/net", "protocols/ports",
      "world/api/description", "world/base"}},
    {"protocols/web/jog",
     {"proto/aprsim/v1", "world/api/commands", "world/api/ports", "world/api/snapshot",
      "world/base"}},
    {"protocols/web/topics",
     {"modbus", "proto/aprsim/v1", "protocols/access", "protocols/conveyor", "protocols/messages",
      "protocols/net", "protocols/ports", "protocols/record", "world/api/description",
      "world/api/ports", "world/api/snapshot", "world/api/values", "world/base"}},
    {"protocols/web/viewer",
     {"modbus", "proto/aprsim/v1", "protocols/access", "protocols/conveyor", "protocols/messages",
      "protocols/net", "protocols/ports", "protocols/record", "protocols/web/http",
      "protocols/web/jog", "protocols/web/topics", "world/api/commands", "world/api/description",
      "world/api/ports", "world/base"}},
    {"server",
     {"proto/journal",    "protocols/grpc",   "protocols/modbus",  "protocols/web",
      "server/access",    "server/cameras",   "server/config",     "server/drafts",
      "server/journal",   "server/listeners", "server/operations", "server/programs",
      "server/replay",    "world/base",       "world/base/files",  "world/base/process",
      "world/base/usage", "world/cell",       "world/runtime",     "world/runtime/history",
      "world/scene",      "world/scene/model"}},
    {"server/access",
     {"protocols/access", "protocols/net", "server/config", "server/operations", "world/api/ports",
      "world/base", "world/base/usage", "world/base/yaml"}},
    {"server/cameras",
     {"protocols/ports", "world/api/ports", "world/base", "world/render", "world/render/cell",
      "world/scene", "world/scene/model"}},
    {"server/config", {"protocols/net", "world/api/commands", "world/base", "world/base/yaml"}},
    {"server/drafts",
     {"protocols/ports", "world/api/snapshot", "world/base", "world/base/yaml", "world/cell",
      "world/devices", "world/robot/kinematics/choice", "world/scenario", "world/scene",
      "world/scene/model"}},
    {"server/embedded",
     {"crcl", "proto/aprsim/v1", "protocols/crcl", "protocols/messages", "protocols/ports",
      "server/listeners", "world/api/description", "world/api/ports", "world/base",
      "world/cell/commands", "world/runtime", "world/runtime/preview", "world/runtime/publish",
      "world/scene", "world/scene/model"}},
    {"server/journal",
     {"proto/aprsim/v1", "proto/journal", "protocols/messages", "protocols/ports",
      "world/api/commands", "world/base", "world/cell", "world/devices", "world/runtime/record",
      "world/scene", "world/scene/model"}},
    {"server/listeners",
     {"crcl",
      "protocols/cameras",
      "protocols/crcl",
      "protocols/grpc",
      "protocols/modbus",
      "protocols/net",
      "protocols/ports",
      "protocols/simple_message",
      "protocols/vision",
      "protocols/web",
      "protocols/web/topics",
      "server/access",
      "server/config",
      "server/operations",
      "world/api/commands",
      "world/api/description",
      "world/api/ports",
      "world/base",
      "world/base/process",
      "world/scene",
      "world/scene/model"}},
    {"server/operations",
     {"protocols/access", "protocols/cameras", "protocols/crcl", "protocols/grpc",
      "protocols/modbus", "protocols/net", "protocols/ports", "protocols/simple_message",
      "protocols/vision", "protocols/web", "server/config", "server/journal", "world/api/ports",
      "world/api/snapshot", "world/base", "world/runtime/history"}},
    {"server/programs",
     {"protocols/net", "protocols/ports", "server/access", "server/config", "server/operations",
      "world/base/process", "world/scenario", "world/scene"}},
    {"server/replay",
     {"crcl",
      "modbus",
      "proto/aprsim/v1",
      "proto/journal",
      "protocols/conveyor",
      "protocols/crcl",
      "protocols/grpc",
      "protocols/messages",
      "protocols/modbus",
      "protocols/modbus/banks",
      "protocols/record",
      "protocols/simple_message",
      "protocols/simple_message/codec",
      "protocols/vision",
      "protocols/web",
      "protocols/web/http",
      "protocols/web/topics",
      "server/access",
      "server/cameras",
      "server/config",
      "server/journal",
      "server/listeners",
      "server/operations",
      "world/api/description",
      "world/api/ports",
      "world/api/snapshot",
      "world/base",
      "world/base/files",
      "world/cell",
      "world/cell/commands",
      "world/devices",
      "world/render",
      "world/render/cell",
      "world/runtime/history",
      "world/runtime/publish",
      "world/runtime/record",
      "world/scene",
      "world/scene/model"}},
    {"world/api/commands", {"world/api/faults", "world/api/values", "world/base"}},
    {"world/api/description", {"world/api/values", "world/base"}},
    {"world/api/faults", {"world/api/values", "world/base"}},
    {"world/api/ports",
     {"world/api/commands", "world/api/snapshot", "world/api/values", "world/base"}},
    {"world/api/signals",
     {"world/api/commands", "world/api/description", "world/api/snapshot", "world/base"}},
    {"world/api/snapshot",
     {"world/api/commands", "world/api/description", "world/api/faults", "world/api/values",
      "world/base"}},
    {"world/api/values", {"world/base"}},
    {"world/archive", {"world/base"}},
    {"world/base", {}},
    {"world/base/files", {"world/base"}},
    {"world/base/process", {"world/base"}},
    {"world/base/simd", {}},
    {"world/base/usage", {}},
    {"world/base/yaml", {"world/base"}},
    {"world/cell",
     {"world/api/commands", "world/api/description", "world/api/snapshot", "world/api/values",
      "world/archive", "world/base", "world/cell/machines", "world/cell/observation",
      "world/devices", "world/devices/interface", "world/faults", "world/physics",
      "world/physics/bodies", "world/robot/model", "world/scene", "world/scene/model",
      "world/sensors"}},
    {"world/cell/commands",
     {"world/api/commands", "world/api/description", "world/api/snapshot", "world/base",
      "world/cell", "world/devices", "world/faults", "world/scene", "world/scene/model"}},
    {"world/cell/machines",
     {"world/api/commands", "world/api/description", "world/api/snapshot", "world/cell/robot",
      "world/faults", "world/physics/contacts", "world/physics/gripper", "world/robot/controller",
      "world/robot/kinematics", "world/robot/model", "world/robot/servo", "world/scene/model"}},
    {"world/cell/observation",
     {"world/api/snapshot", "world/api/values", "world/cell/machines", "world/physics",
      "world/physics/bodies", "world/physics/contacts", "world/robot/avoidance",
      "world/robot/kinematics", "world/scene/model", "world/sensors"}},
    {"world/cell/robot",
     {"world/api/commands", "world/api/description", "world/api/snapshot", "world/faults",
      "world/base", "world/physics/contacts", "world/physics/gripper", "world/robot/controller",
      "world/robot/kinematics", "world/robot/kinematics/choice", "world/robot/model",
      "world/robot/servo", "world/scene/model", "world/sensors"}},
    {"world/devices",
     {"world/api/commands", "world/api/description", "world/api/signals", "world/api/snapshot",
      "world/base", "world/devices/interface", "world/scene", "world/scene/model"}},
    {"world/devices/interface", {}},
    {"world/faults",
     {"world/api/description", "world/api/faults", "world/api/snapshot", "world/api/values",
      "world/base", "world/physics/gripper", "world/sensors"}},
    {"world/physics",
     {"world/api/snapshot", "world/physics/bodies", "world/physics/constraint",
      "world/physics/contacts", "world/physics/gripper", "world/physics/model",
      "world/physics/state", "world/physics/step", "world/robot/model", "world/scene/model"}},
    {"world/physics/bodies",
     {"world/physics/collision/pairs", "world/physics/collision/shapes",
      "world/physics/collision/speculative", "world/robot/model", "world/scene/model"}},
    {"world/physics/collision/pairs",
     {"world/base/simd", "world/physics/collision/reduction", "world/physics/collision/shapes",
      "world/physics/collision/speculative", "world/scene/model"}},
    {"world/physics/collision/reduction", {"world/physics/collision/shapes"}},
    {"world/physics/collision/shapes", {"world/api/values", "world/scene/model"}},
    {"world/physics/collision/speculative",
     {"world/physics/collision/shapes", "world/scene/model"}},
    {"world/physics/constraint",
     {"world/base/simd", "world/physics/bodies", "world/physics/engine"}},
    {"world/physics/contacts",
     {"world/api/snapshot", "world/base/simd", "world/physics/bodies",
      "world/physics/collision/pairs", "world/physics/collision/shapes",
      "world/physics/collision/speculative", "world/physics/model", "world/robot/servo",
      "world/scene/model"}},
    {"world/physics/engine", {"world/physics/bodies"}},
    {"world/physics/gripper",
     {"world/api/values", "world/physics/bodies", "world/physics/collision/pairs",
      "world/physics/collision/shapes", "world/physics/collision/speculative",
      "world/physics/engine", "world/scene/model"}},
    {"world/physics/model",
     {"world/api/snapshot", "world/physics/bodies", "world/physics/gripper",
      "world/physics/simplification"}},
    {"world/physics/ode", {"world/physics/bodies", "world/physics/engine", "world/scene/model"}},
    {"world/physics/simplification",
     {"world/api/snapshot", "world/physics/bodies", "world/physics/collision/speculative",
      "world/physics/engine", "world/scene/model"}},
    {"world/physics/state",
     {"world/api/snapshot", "world/archive", "world/physics/bodies", "world/physics/model",
      "world/physics/step"}},
    {"world/physics/step",
     {"world/api/snapshot", "world/base/simd", "world/physics/bodies",
      "world/physics/collision/speculative", "world/physics/constraint", "world/physics/contacts",
      "world/physics/engine", "world/physics/model", "world/physics/ode", "world/scene/model"}},
    {"world/render",
     {"world/api/faults", "world/base", "world/base/simd", "world/render/mesh",
      "world/render/raster", "world/scene/model"}},
    {"world/render/cell",
     {"world/api/description", "world/api/snapshot", "world/api/values", "world/base",
      "world/render/mesh", "world/render/raster", "world/robot/kinematics", "world/robot/model",
      "world/scene/model"}},
    {"world/render/mesh", {"world/base/simd"}},
    {"world/render/raster", {"world/base/simd", "world/render/mesh", "world/scene/model"}},
    {"world/robot/avoidance",
     {"world/api/values", "world/base", "world/robot/kinematics", "world/robot/model",
      "world/robot/trajectory/profile"}},
    {"world/robot/controller",
     {"world/api/commands", "world/api/snapshot", "world/api/values", "world/base",
      "world/robot/kinematics", "world/robot/model", "world/robot/planning", "world/robot/servo",
      "world/robot/trajectory", "world/robot/trajectory/limits", "world/robot/trajectory/profile",
      "world/robot/trajectory/stream"}},
    {"world/robot/kinematics", {"world/api/values", "world/robot/model"}},
    {"world/robot/kinematics/choice",
     {"world/robot/kinematics", "world/robot/kinematics/families", "world/robot/kinematics/numeric",
      "world/robot/model"}},
    {"world/robot/kinematics/families", {"world/robot/kinematics", "world/robot/model"}},
    {"world/robot/kinematics/numeric", {"world/robot/kinematics", "world/robot/model"}},
    {"world/robot/model", {"world/base"}},
    {"world/robot/planning",
     {"world/api/commands", "world/base", "world/robot/avoidance", "world/robot/kinematics",
      "world/robot/model", "world/robot/servo", "world/robot/trajectory",
      "world/robot/trajectory/limits", "world/robot/trajectory/profile",
      "world/robot/trajectory/stream"}},
    {"world/robot/servo", {"world/robot/kinematics", "world/robot/model"}},
    {"world/robot/trajectory",
     {"world/robot/kinematics", "world/robot/model", "world/robot/trajectory/limits",
      "world/robot/trajectory/path", "world/robot/trajectory/profile"}},
    {"world/robot/trajectory/limits",
     {"world/api/commands", "world/api/snapshot", "world/robot/kinematics",
      "world/robot/trajectory/path", "world/robot/trajectory/profile"}},
    {"world/robot/trajectory/path",
     {"world/base", "world/robot/kinematics", "world/robot/model",
      "world/robot/trajectory/profile"}},
    {"world/robot/trajectory/profile", {"world/robot/kinematics", "world/robot/model"}},
    {"world/robot/trajectory/stream",
     {"world/base", "world/robot/kinematics", "world/robot/model", "world/robot/trajectory",
      "world/robot/trajectory/profile"}},
    {"world/runtime",
     {"world/api/commands", "world/api/ports", "world/api/snapshot", "world/api/values",
      "world/base", "world/cell", "world/cell/commands", "world/faults", "world/robot/planning",
      "world/robot/trajectory/profile", "world/runtime/commands", "world/runtime/preview",
      "world/runtime/publish", "world/runtime/record", "world/runtime/time", "world/scene/model"}},
    {"world/runtime/commands", {"world/api/commands", "world/api/snapshot", "world/base"}},
    {"world/runtime/history",
     {"world/api/ports", "world/cell", "world/runtime/record", "world/scene/model"}},
    {"world/runtime/preview", {"world/api/commands", "world/api/ports", "world/cell"}},
    {"world/runtime/publish", {"world/api/snapshot", "world/api/values", "world/runtime/record"}},
    {"world/runtime/record", {"world/api/values", "world/cell", "world/runtime/commands"}},
    {"world/runtime/time", {"world/api/commands", "world/api/ports", "world/api/snapshot"}},
    {"world/scenario",
     {"world/api/faults", "world/base", "world/base/yaml", "world/scene", "world/scene/model",
      "world/scene/readers"}},
    {"world/scene",
     {"world/api/values", "world/base", "world/base/yaml", "world/scene/checks",
      "world/scene/files", "world/scene/model", "world/scene/readers"}},
    {"world/scene/checks", {"world/base/yaml", "world/scene/model"}},
    {"world/scene/files", {"world/base/yaml", "world/scene/model"}},
    {"world/scene/model", {"world/api/description", "world/api/values"}},
    {"world/scene/readers",
     {"world/api/signals", "world/api/values", "world/base/yaml", "world/scene/checks",
      "world/scene/files", "world/scene/model"}},
    {"world/sensors",
     {"world/api/description", "world/api/snapshot", "world/api/values", "world/robot/model",
      "world/scene/model"}},
};

/// Headers that only the named folders may see.
const std::map<std::string, std::set<std::string>> kForeign = {
    {"<dds/", {"clients/ros2/dds"}},
    {"<ode/", {"world/physics/bodies", "world/physics/ode"}},
    {"<xercesc/", {"crcl"}},
    {"<modbus/", {"protocols/modbus", "clients/wires"}},
    {"<modbus.h", {"protocols/modbus", "clients/wires"}},
    {"<grpc", {"protocols/grpc", "clients/wires", "proto"}},
    {"<ompl/", {"world/robot/avoidance"}},
    {"<urdf", {"world/robot/model"}},
    {"<boost/beast", {"protocols/web"}},
    {"<boost/asio", {"protocols", "server"}},
    {"<yaml-cpp/", {"world/base/yaml"}},
    {"<zstd", {"proto/journal"}},
    {"<pcap", {"clients/aprsim/trace"}},
};

std::string folder_of(const std::string& path) { return fs::path(path).parent_path().string(); }

bool within(const std::string& path, const std::set<std::string>& folders) {
  for (const auto& folder : folders) {
    if (path.starts_with(folder + "/")) return true;
  }
  return false;
}

std::vector<fs::path> sources() {
  std::vector<fs::path> out;
  const fs::path root = APRSIM_SOURCE_DIR;
  for (const auto* top : {"world", "crcl", "modbus", "proto", "protocols", "server", "clients"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const auto extension = entry.path().extension();
      if (extension == ".hpp" || extension == ".cpp") out.push_back(entry.path());
    }
  }
  return out;
}

template <typename Check>
void for_each_include(const Check& check) {
  for (const auto& file : sources()) {
    const std::string path = fs::relative(file, APRSIM_SOURCE_DIR).string();
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("#include ")) check(path, line.substr(9));
    }
  }
}

/// The rooms that each room includes, as the sources have it.
std::map<std::string, std::set<std::string>> found_arrows() {
  std::map<std::string, std::set<std::string>> found;
  for (const auto& file : sources()) {
    found.try_emplace(folder_of(fs::relative(file, APRSIM_SOURCE_DIR).string()));
  }
  for_each_include([&](const std::string& path, const std::string& include) {
    if (!include.starts_with('"')) return;
    const std::string target = include.substr(1, include.rfind('"') - 1);
    const std::string to = folder_of(target.starts_with("aprsim/") ? "proto/" + target : target);
    if (to != folder_of(path)) found[folder_of(path)].insert(to);
  });
  return found;
}

TEST(Arrows, EveryRoomIncludesWhatItsRowSays) {
  const auto found = found_arrows();
  for (const auto& [room, targets] : found) {
    ASSERT_TRUE(kArrows.contains(room)) << room << " has no row";
    for (const auto& to : targets) {
      EXPECT_TRUE(kArrows.at(room).contains(to)) << room << " may not include " << to;
    }
  }
  for (const auto& [room, targets] : kArrows) {
    ASSERT_TRUE(found.contains(room)) << room << " is no room";
    for (const auto& to : targets) {
      EXPECT_TRUE(found.at(room).contains(to)) << room << " does not include " << to;
    }
  }
}

/// The folder directly below `parent` that a room lies in; "." for `parent` itself, empty for a
/// room elsewhere.
std::string part_of(const std::string& parent, const std::string& room) {
  if (room == parent) return ".";
  const std::string prefix = parent.empty() ? "" : parent + "/";
  if (!room.starts_with(prefix)) return "";
  return room.substr(prefix.size(), room.find('/', prefix.size()) - prefix.size());
}

/// Removes parts that include no remaining part until none is left, or only circles are.
std::set<std::string> circles_below(const std::string& parent) {
  std::map<std::string, std::set<std::string>> parts;
  for (const auto& [room, targets] : kArrows) {
    const std::string from = part_of(parent, room);
    if (from.empty()) continue;
    parts.try_emplace(from);
    for (const auto& target : targets) {
      const std::string to = part_of(parent, target);
      if (!to.empty() && to != from) parts[from].insert(to);
    }
  }
  for (bool removed = true; removed;) {
    removed = false;
    for (auto it = parts.begin(); it != parts.end();) {
      const bool free = std::ranges::none_of(
          it->second, [&](const std::string& to) { return parts.contains(to); });
      removed |= free;
      it = free ? parts.erase(it) : std::next(it);
    }
  }
  std::set<std::string> out;
  for (const auto& [part, unused] : parts) out.insert(part);
  return out;
}

TEST(Arrows, NoCircleBetweenRoomsOnAnyLevel) {
  std::set<std::string> parents = {""};
  for (const auto& [room, unused] : kArrows) {
    for (std::string at = room; !at.empty(); at = folder_of(at)) parents.insert(at);
  }
  for (const auto& parent : parents) {
    for (const auto& part : circles_below(parent)) {
      ADD_FAILURE() << part << " below '" << parent << "' is part of, or includes, a circle";
    }
  }
}

TEST(Arrows, AtMostEightUnitsAtARoot) {
  for (const auto* root : {"world", "server", "protocols", "clients", "clients/aprsim", "world/api",
                           "world/physics", "world/runtime", "protocols/grpc", "protocols/web"}) {
    std::set<std::string> units;
    for (const auto& file : sources()) {
      const fs::path path = fs::relative(file, APRSIM_SOURCE_DIR);
      if (path.parent_path() == root) units.insert(path.stem().string());
    }
    EXPECT_LE(units.size(), 8U) << root;
  }
}

TEST(Arrows, ForeignLibrariesStayInTheirFolder) {
  for_each_include([&](const std::string& path, const std::string& include) {
    for (const auto& [prefix, folders] : kForeign) {
      if (include.starts_with(prefix)) {
        EXPECT_TRUE(within(path, folders)) << path << " may not include " << include;
      }
    }
  });
}

TEST(Arrows, NothingButTheAgreedFoldersAtTheTop) {
  const std::set<std::string> agreed = {"CMakeLists.txt", "CMakePresets.json",
                                        "README.md",      "ARCHITECTURE.md",
                                        "LICENSE",        "NOTICE",
                                        "SECURITY.md",    "CONTRIBUTING.md",
                                        "CHANGELOG.md",   "server",
                                        "protocols",      "crcl",
                                        "modbus",         "world",
                                        "proto",          "clients",
                                        "tests",          "docker",
                                        "docs",           "build"};
  for (const auto& entry : fs::directory_iterator(APRSIM_SOURCE_DIR)) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.starts_with('.') || agreed.contains(name)) << name;
  }
}

}  // namespace
