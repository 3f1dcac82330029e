#include <filesystem>
#include <random>
#include <sstream>

#include "tests/support/case_count.hpp"
#include "tests/unit/world/scene/scene_fixture.hpp"

namespace aprsim::scene {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

/// Something that goes wrong while a person edits a file.
void mutate(std::vector<std::string>& lines, std::mt19937& random) {
  static const std::vector<std::string> kValues = {
      "-1",        "0",  "1e308", "-1e308",    "1e-320", ".nan", "nan",  "",
      "~",         "[]", "{}",    "[",         "}",      "'",    "&a 1", "*a",
      "!!x 1",     "x",  "true",  "[1, 2, 3]", "{a: 1}", "? a",  "- 1",  "99999999999999999999",
      "\"\\x00\"", "|",  ">-",    "%YAML",     "\t",     ": :"};
  const auto pick = [&](std::size_t count) { return random() % count; };
  std::string& line = lines[pick(lines.size())];
  const std::size_t colon = line.find(": ");
  switch (pick(8)) {
    case 0:  // another value
      if (colon != std::string::npos)
        line = line.substr(0, colon + 2) + kValues[pick(kValues.size())];
      break;
    case 1:  // a value inside a flow map or list
      if (const std::size_t comma = line.find_last_of(",[:"); comma != std::string::npos) {
        line.insert(comma + 1, " " + kValues[pick(kValues.size())]);
      }
      break;
    case 2:  // a slip in a key or word
      if (!line.empty()) line[pick(line.size())] = static_cast<char>('!' + pick(94));
      break;
    case 3:  // a lost character
      if (!line.empty()) line.erase(pick(line.size()), 1);
      break;
    case 4:  // another indentation
      line.insert(0, 1 + pick(4), ' ');
      break;
    case 5:  // a line twice
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(pick(lines.size())), line);
      break;
    case 6:  // a lost line
      line.clear();
      break;
    default:  // cut short
      lines.resize(1 + pick(lines.size()));
  }
}

class MutatedScenes : public SceneFiles {};

TEST_F(MutatedScenes, LoadOrSayWhereTheyAreWrong) {
  copy_shipped_scenes();
  std::mt19937 random(20190611);
  const std::vector<std::string> files = {"aprs.yaml",         "table1.yaml",
                                          "fanuc_only.yaml",   "types/gears_2017.yaml",
                                          "types/robots.yaml", "empty_belt.yaml"};
  int refused = 0;
  const int runs = test::case_count(1500);
  for (int run = 0; run < runs; ++run) {
    const std::string& name = files[random() % files.size()];
    const std::string original = read_file(directory_ + '/' + name);
    std::vector<std::string> lines = lines_of(original);
    for (auto count = 1 + random() % 3; count > 0; --count) mutate(lines, random);
    write(name, text_of(lines));
    const auto scene = load(name.starts_with("types/") ? "aprs" : directory_ + '/' + name);
    write(name, original);
    if (scene) continue;
    ++refused;
    EXPECT_EQ(scene.error().message.rfind(directory_ + '/', 0), 0u)
        << "run " << run << ": " << scene.error().message;
    EXPECT_NE(scene.error().message.find(": found "), std::string::npos)
        << "run " << run << ": " << scene.error().message;
  }
  EXPECT_GT(refused, runs / 2);
  EXPECT_LT(refused, runs);
}

TEST_F(MutatedScenes, AKeyTooManyIsRefusedInEveryMap) {
  copy_shipped_scenes();
  int maps = 0;
  for (const char* name :
       {"aprs.yaml", "types/gears_2024.yaml", "types/trays_2025.yaml", "types/robots.yaml"}) {
    const std::string original = read_file(directory_ + '/' + name);
    const bool newer = std::string(name).find("_202") != std::string::npos;
    const std::string scene_file = newer ? "aprs_2025" : "aprs";
    const std::vector<std::string> lines = lines_of(original);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::size_t indent = lines[i].find_first_not_of(" -");
      if (indent == std::string::npos || lines[i][indent] == '#') continue;
      if (lines[i][indent] == '[') continue;  // goes on with a list
      std::vector<std::string> changed = lines;
      if (const std::size_t brace = lines[i].find('{'); brace != std::string::npos) {
        changed[i].insert(brace + 1, "surplus: 1, ");
      } else {
        changed.insert(changed.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                       std::string(indent, ' ') + "surplus: 1");
        if (lines[i].ends_with(':')) {  // its own map or list follows: put the key before it
          std::swap(changed[i], changed[i + 1]);
          if (const std::size_t dash = changed[i + 1].find('-'); dash < indent) continue;
        }
      }
      write(name, text_of(changed));
      const auto scene = load(scene_file);
      ASSERT_FALSE(scene.has_value()) << name << ':' << i + 1 << ": " << lines[i];
      EXPECT_NE(scene.error().message.find("surplus"), std::string::npos)
          << name << ':' << i + 1 << ": " << scene.error().message;
      ++maps;
    }
    write(name, original);
  }
  EXPECT_GT(maps, 150);
}

}  // namespace
}  // namespace aprsim::scene
