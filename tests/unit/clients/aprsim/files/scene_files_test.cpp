#include "clients/aprsim/files/scene_files.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

#include <gtest/gtest.h>

#include "clients/aprsim/files/file_diff.hpp"
#include "clients/aprsim/files/file_format.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::client {
namespace {

namespace fs = std::filesystem;

const scene::DataPaths& paths() {
  static const scene::DataPaths kPaths = scene::default_data_paths();
  return kPaths;
}

FoundFile found(FileKind kind, const std::string& name) {
  auto file = find_file(kind, name, paths());
  if (!file) throw std::runtime_error(file.error().message);
  return *std::move(file);
}

/// Every shipped scene, file of types and scenario.
std::vector<FoundFile> shipped() {
  std::vector<FoundFile> out;
  for (const auto& name : scene::names_in(paths().scenes)) {
    out.push_back(found(FileKind::kScene, name));
  }
  for (const auto& entry : fs::directory_iterator(paths().scenes + "/types")) {
    out.push_back(found(FileKind::kScene, entry.path().string()));
  }
  for (const auto& name : scene::names_in(paths().scenarios)) {
    out.push_back(found(FileKind::kScenario, name));
  }
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::out_of_range("no " + from);
  return text.replace(at, from.size(), to);
}

/// The file beside the shipped scenes with another text, not written.
FoundFile changed(const FoundFile& file, const std::string& from, const std::string& to) {
  FoundFile out = file;
  out.text = replaced(out.text, from, to);
  return out;
}

std::vector<std::string> keys_of(const std::vector<Problem>& problems) {
  std::vector<std::string> out;
  for (const Problem& problem : problems) out.push_back(problem.key);
  return out;
}

std::string line_at(const std::string& text, int number) {
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i < number; ++i) std::getline(lines, line);
  return line;
}

TEST(SceneFiles, ShippedFilesHaveNoErrors) {
  for (const FoundFile& file : shipped()) {
    const CheckedFile checked = check_file(file, paths());
    for (const Problem& problem : checked.problems) {
      EXPECT_TRUE(problem.is_warning) << file.path << ": " << problem.message;
    }
  }
}

TEST(SceneFiles, KindFollowsFromTheKeys) {
  EXPECT_EQ(found(FileKind::kScene, "aprs").kind, FileKind::kScene);
  EXPECT_EQ(found(FileKind::kScene, paths().scenes + "/types/robots.yaml").kind, FileKind::kTypes);
  EXPECT_FALSE(find_file(FileKind::kScene, "arps", paths()));
  EXPECT_FALSE(find_file(FileKind::kScenario, "/no/such.yaml", paths()));
}

TEST(SceneFiles, AllErrorsAreFoundWithTheirPlaces) {
  FoundFile file = found(FileKind::kScene, "aprs");
  file = changed(file, "  gravity_m_s2: 9.81", "  gravty_m_s2: 9.81");
  file = changed(file, "gear_gear: 0.3", "gear_gear: -0.3");
  file = changed(file, "xyz_m: [0, 0, 0.91]", "xyz_m: [0, 0]");
  const CheckedFile checked = check_file(file, paths());
  EXPECT_EQ(keys_of(checked.problems),
            (std::vector<std::string>{"physics.gravty_m_s2", "physics.friction.gear_gear",
                                      "robots[1].base.xyz_m"}));
  for (const Problem& problem : checked.problems) {
    const std::string key = problem.key.substr(problem.key.rfind('.') + 1);
    EXPECT_NE(line_at(file.text, problem.line).find(key), std::string::npos) << problem.line;
    EXPECT_GT(problem.column, 0);
  }
  EXPECT_NE(checked.problems[0].message.find("did you mean gravity_m_s2?"), std::string::npos);
  EXPECT_EQ(checked.problems[1].message, "found -0.3, expected a number >= 0");
  EXPECT_EQ(checked.errors(), 3U);
  EXPECT_FALSE(checked.scene);
}

TEST(SceneFiles, ScenariosTellAllErrorsToo) {
  FoundFile file = found(FileKind::kScenario, "clean_2017");
  file = changed(file, "time_limit_s: 600", "time_limit_s: 0");
  file = changed(file, "baseline_s: 55.6, baseline_score: 60", "baseline: 55.6, tray: -1");
  EXPECT_EQ(keys_of(check_file(file, paths()).problems),
            (std::vector<std::string>{"stop.time_limit_s", "scoring.baseline", "scoring.tray"}));
}

TEST(SceneFiles, BodiesOutOfReachAndUnusedTypesAreWarnings) {
  FoundFile file = found(FileKind::kScene, "fanuc_only");
  file.text +=
      "\npockets:\n  spare: {top_radius_m: 0.01, floor_radius_m: 0.01, depth_m: 0.01}\n"
      "gears:\n  - {name: far, type: sku_part_large_gear, xyz_m: [5, 5, 0.1]}\n";
  file = changed(file, "types/robots.yaml", "[types/robots.yaml, types/gears_2017.yaml]");
  const CheckedFile checked = check_file(file, paths());
  EXPECT_EQ(checked.errors(), 0U) << (checked.problems.empty() ? "" : checked.problems[0].message);
  EXPECT_EQ(keys_of(checked.problems), (std::vector<std::string>{"far", "pockets.spare"}));
  EXPECT_NE(line_at(file.text, checked.problems[0].line).find("name: far"), std::string::npos);
}

TEST(FileFormat, ShippedFilesKeepTheirMeaningAndFormattingAgainChangesNothing) {
  for (const FoundFile& file : shipped()) {
    const auto once = format_file(file);
    ASSERT_TRUE(once.has_value()) << once.error().message;
    FoundFile formatted = file;
    formatted.text = *once;
    const auto twice = format_file(formatted);
    ASSERT_TRUE(twice.has_value()) << twice.error().message;
    EXPECT_EQ(*once, *twice) << file.path;
    EXPECT_EQ(check_file(formatted, paths()).errors(), 0U) << file.path;
    std::istringstream lines(*once);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_FALSE(line.ends_with(' ')) << file.path << ": " << line;
      EXPECT_TRUE(line.size() <= 100 || line.find('#') != std::string::npos ||
                  line.find("description") != std::string::npos ||
                  line.find(": \"") != std::string::npos)
          << file.path << ": " << line;
    }
  }
}

TEST(FileFormat, OrdersKeysAndKeepsComments) {
  FoundFile file{.path = "f.yaml",
                 .text =
                     "# About the file.\n\n"
                     "trays: []   # none yet\n"
                     "\n\n"
                     "# The seed.\n"
                     "'seed':   2\n"
                     "robots:\n"
                     "# First.\n"
                     "- type:  arm  # a type\n"
                     "  # Its name.\n"
                     "  name: a\n"
                     "  base: { rpy_deg: [0,0,90], xyz_m: [ 0, 0,1.0] }\n"
                     "# The end.\n"};
  const auto text = format_file(file);
  ASSERT_TRUE(text.has_value()) << text.error().message;
  EXPECT_EQ(*text,
            "# About the file.\n\n"
            "# The seed.\n"
            "seed: 2\n"
            "robots:\n"
            "  # First.\n"
            "  # Its name.\n"
            "  - name: a\n"
            "    type: arm  # a type\n"
            "    base: {xyz_m: [0, 0, 1.0], rpy_deg: [0, 0, 90]}\n"
            "trays: []  # none yet\n"
            "# The end.\n");
}

TEST(FileFormat, RefusesWhatItWouldLose) {
  const auto refused = [](const std::string& text) {
    return !format_file({.path = "f.yaml", .text = text}).has_value();
  };
  EXPECT_TRUE(refused("robots: [  # a comment\n  # within\n  ]\n"));
  EXPECT_TRUE(refused("seed: [\n"));
  EXPECT_FALSE(refused("seed: 1  # a comment with 'quotes\n"));
}

std::vector<Difference> differences(const FoundFile& a, const FoundFile& b) {
  auto out = diff_files(a, b, paths());
  if (!out) throw std::runtime_error(out.error().message);
  return *std::move(out);
}

TEST(FileDiff, AFileDoesNotDifferFromItself) {
  for (const FoundFile& file : shipped()) {
    EXPECT_TRUE(differences(file, file).empty()) << file.path;
  }
}

/// The same of a formatted file: it describes what it did before.
TEST(FileDiff, FormattingIsNoDifference) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("aprsim_diff_" + std::to_string(getpid()));
  fs::copy(paths().scenes, folder, fs::copy_options::recursive);
  for (const auto& name : scene::names_in(paths().scenes)) {
    const FoundFile before = found(FileKind::kScene, (folder / (name + ".yaml")).string());
    const auto text = format_file(before);
    ASSERT_TRUE(text.has_value()) << text.error().message;
    const fs::path place = folder / (name + "_again.yaml");
    std::ofstream(place) << *text;
    EXPECT_TRUE(differences(before, found(FileKind::kScene, place.string())).empty()) << name;
  }
  fs::remove_all(folder);
}

TEST(FileDiff, TellsWhatWasAddedRemovedMovedAndChanged) {
  const auto text_file = [](std::string text) {
    return FoundFile{.path = "f.yaml", .text = std::move(text), .kind = FileKind::kTypes};
  };
  const FoundFile a = text_file(
      "fixed:\n  - {name: one, xyz_m: [0, 0, 0]}\n  - {name: two, xyz_m: [0, 0, 0]}\n"
      "pockets:\n  p: {depth_m: 0.01}\n");
  const FoundFile b = text_file(
      "pockets:\n  p: {depth_m: 0.02, chamfer_angle_deg: 45}\n"
      "fixed:\n  - {name: three, xyz_m: [0, 0, 0]}\n  - {xyz_m: [3.0e-3, 0, -4e-3], name: one}\n");
  const auto found = differences(a, b);
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].kind, Difference::Kind::kMoved);
  EXPECT_EQ(found[0].key, "fixed.one.xyz_m");
  EXPECT_NEAR(found[0].moved_m, 5e-3, 1e-12);
  EXPECT_EQ(found[0].unit, "m");
  EXPECT_EQ(text_of(found[0]),
            "~ fixed.one.xyz_m: [0, 0, 0] -> [3.0e-3, 0, -4e-3] m, moved by 5 mm");
  EXPECT_EQ(found[1].kind, Difference::Kind::kRemoved);
  EXPECT_EQ(found[1].key, "fixed.two");
  EXPECT_EQ(found[2].kind, Difference::Kind::kAdded);
  EXPECT_EQ(found[2].key, "fixed.three");
  EXPECT_EQ(text_of(found[3]), "~ pockets.p.depth_m: 0.01 -> 0.02 m");
}

}  // namespace
}  // namespace aprsim::client
