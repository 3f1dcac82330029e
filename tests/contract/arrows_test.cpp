// The arrows of ARCHITECTURE.md, checked against every #include of ours.

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

/// What a folder may include of ours, besides itself; the longest prefix of a path rules.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"world/fault_kinds", {}},
    {"world/api", {"world/fault_kinds"}},
    {"world/archive", {"world/api"}},
    {"world/scene", {"world/api"}},
    {"world/scenario", {"world/fault_kinds", "world/api", "world/scene"}},
    {"world/robot", {"world/api"}},
    {"world/physics/collision", {"world/api", "world/scene"}},
    {"world/physics/bodies",
     {"world/api", "world/scene", "world/robot", "world/physics/collision"}},
    {"world/physics/constraint", {"world/api", "world/physics/collision", "world/physics/bodies"}},
    {"world/physics/gripper",
     {"world/api", "world/scene", "world/physics/collision", "world/physics/bodies",
      "world/physics/constraint"}},
    {"world/physics/simplification",
     {"world/api", "world/scene", "world/physics/collision", "world/physics/bodies",
      "world/physics/constraint"}},
    {"world/physics",
     {"world/api", "world/archive", "world/scene", "world/robot", "world/physics/collision",
      "world/physics/bodies", "world/physics/constraint", "world/physics/gripper",
      "world/physics/simplification"}},
    {"world/sensors", {"world/api", "world/scene", "world/robot"}},
    {"world",
     {"world/fault_kinds", "world/api", "world/archive", "world/scene", "world/robot",
      "world/physics", "world/sensors"}},
    {"crcl", {"proto/aprsim/crcl"}},
    {"modbus", {}},
    {"proto", {}},
    {"proto/aprsim/crcl", {}},
    {"proto/journal", {"proto", "world/api"}},
    {"protocols",
     {"crcl", "modbus", "proto", "proto/aprsim/crcl", "world/fault_kinds", "world/api"}},
    {"clients/process", {"world/api"}},
    {"server",
     {"server/journal", "protocols", "crcl", "clients/process", "proto", "proto/journal",
      "world/fault_kinds", "world", "world/api", "world/scene", "world/scenario"}},
    {"server/journal",
     {"server", "protocols", "crcl", "modbus", "proto", "proto/journal", "world/fault_kinds",
      "world", "world/api", "world/scene"}},
    {"clients",
     {"crcl", "modbus", "clients/process", "proto", "proto/aprsim/crcl", "proto/journal",
      "world/fault_kinds", "world/api", "world/scene", "world/scenario"}},
};

/// Headers that only the named folders may see.
const std::map<std::string, std::set<std::string>> kForeign = {
    {"<ode/", {"world/physics"}},
    {"<xercesc/", {"crcl"}},
    {"<modbus/", {"protocols/modbus", "clients/aprsim"}},
    {"<modbus.h", {"protocols/modbus", "clients/aprsim"}},
    {"<grpc", {"protocols/telemetry", "clients/aprsim", "proto"}},
    {"<urdf", {"world/robot"}},
    {"<boost/beast", {"protocols/web"}},
    {"<boost/asio", {"protocols", "clients/aprsim", "server"}},
    {"<yaml-cpp/", {"world/scene"}},
    {"<zstd", {"proto/journal"}},
    {"<pcap", {"clients/aprsim/trace"}},
};

std::string folder_of(const std::string& path) {
  std::string best;
  for (const auto& [folder, unused] : kAllowed) {
    if (path.starts_with(folder + "/") && folder.size() > best.size()) best = folder;
  }
  return best;
}

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

TEST(Arrows, OwnIncludesFollowTheMap) {
  int seen = 0;
  for_each_include([&](const std::string& path, const std::string& include) {
    if (!include.starts_with('"')) return;
    const std::string target = include.substr(1, include.rfind('"') - 1);
    const std::string from = folder_of(path);
    const std::string to = folder_of(target.starts_with("aprsim/") ? "proto/" + target : target);
    EXPECT_FALSE(to.empty()) << path << " includes " << target << ", which is no folder of ours";
    ++seen;
    if (from != to) {
      EXPECT_TRUE(kAllowed.at(from).contains(to)) << path << " may not include " << target;
    }
  });
  EXPECT_GT(seen, 50) << "the scan found too little to prove anything";
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
  const std::set<std::string> agreed = {"CMakeLists.txt",
                                        "CMakePresets.json",
                                        "README.md",
                                        "ARCHITECTURE.md",
                                        "LICENSE",
                                        "NOTICE",
                                        "CONTRIBUTING.md",
                                        "CHANGELOG.md",
                                        "server",
                                        "protocols",
                                        "crcl",
                                        "modbus",
                                        "world",
                                        "proto",
                                        "clients",
                                        "tests",
                                        "docker",
                                        "build"};
  for (const auto& entry : fs::directory_iterator(APRSIM_SOURCE_DIR)) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.starts_with('.') || agreed.contains(name)) << name;
  }
}

}  // namespace
