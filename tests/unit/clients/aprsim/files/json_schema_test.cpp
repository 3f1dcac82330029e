#include "clients/aprsim/files/json_schema.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

namespace aprsim::client {
namespace {

using Json = nlohmann::ordered_json;

/// The committed files are what `aprsim scene schema` and `aprsim scenario schema` print.
TEST(JsonSchema, CommittedFilesAreUpToDate) {
  const std::pair<FileKind, const char*> files[] = {
      {FileKind::kScene, "scenes/scene.schema.json"},
      {FileKind::kTypes, "scenes/types.schema.json"},
      {FileKind::kScenario, "scenarios/scenario.schema.json"}};
  for (const auto& [kind, name] : files) {
    std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/world/" + name);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_TRUE(text == json_schema(kind).dump(1) + '\n')
        << name << " differs from what the readers accept: write it again";
  }
}

void collect(const yaml::KeySchema& schema, const std::string& pattern,
             std::set<std::string>& keys) {
  const std::string prefix = pattern.empty() ? "" : pattern + ".";
  for (const auto& [key, value] : schema.keys) {
    keys.insert(prefix + key);
    collect(value, prefix + key, keys);
  }
  if (!schema.values.empty()) collect(schema.values.front(), prefix + "*", keys);
  if (!schema.items.empty()) collect(schema.items.front(), pattern + "[]", keys);
}

TEST(JsonSchema, EveryKeyWithinASectionHasAMeaning) {
  for (const FileKind kind : {FileKind::kScene, FileKind::kTypes, FileKind::kScenario}) {
    std::set<std::string> keys;
    collect(keys_of(kind), "", keys);
    EXPECT_GT(keys.size(), 50U);
    for (const std::string& key : keys) {
      const bool is_section = key.find('.') == std::string::npos;
      EXPECT_TRUE(is_section || !meaning_of(kind, key).empty()) << key;
    }
  }
}

/// A value of which a recording saw no reading would accept anything.
void expect_forms(const Json& schema, const std::string& place) {
  EXPECT_TRUE(schema.contains("type") || schema.contains("enum") || schema.contains("anyOf"))
      << place;
  for (const Json& form : schema.contains("anyOf") ? schema["anyOf"] : Json::array()) {
    expect_forms(form, place);
  }
  if (schema.contains("items")) expect_forms(schema["items"], place + "[]");
  if (schema.contains("properties")) {
    for (const auto& [key, value] : schema["properties"].items()) {
      expect_forms(value, place + "." + key);
    }
  }
  if (schema.contains("additionalProperties") && schema["additionalProperties"].is_object()) {
    expect_forms(schema["additionalProperties"], place + ".*");
  }
}

TEST(JsonSchema, EveryKeyHasItsFormInTheSchema) {
  for (const FileKind kind : {FileKind::kScene, FileKind::kTypes, FileKind::kScenario}) {
    expect_forms(json_schema(kind), "");
  }
}

/// Every line of the tables is about a key that the readers know.
TEST(JsonSchema, EveryMeaningHasItsKey) {
  for (const FileKind kind : {FileKind::kScene, FileKind::kScenario}) {
    std::set<std::string> meanings, keys;
    collect(keys_of(kind), "", keys);
    for (const std::string& key : keys) meanings.insert(meaning_of(kind, key));
    const bool is_scene = kind == FileKind::kScene;
    std::ifstream in(std::string(APRSIM_SOURCE_DIR) + "/docs/site/" +
                     (is_scene ? "scene_keys.txt" : "scenario_keys.txt"));
    for (std::string line; std::getline(in, line);) {
      if (line.empty() || line.starts_with('#')) continue;
      const std::size_t last = line.rfind(" | ");
      const std::string meaning = line.substr(last + 3);
      EXPECT_TRUE(std::ranges::any_of(meanings, [&](const std::string& text) {
        return text.starts_with(meaning + ": ");
      })) << line;
    }
  }
}

TEST(JsonSchema, KnowsWhatTheReadersDemand) {
  const Json scene = json_schema(FileKind::kScene);
  const Json& robot = scene["properties"]["robots"]["items"];
  EXPECT_EQ(robot["required"], Json::array({"name", "type", "base"}));
  EXPECT_EQ(robot["properties"]["clearance_m"]["default"], 0.01);
  EXPECT_EQ(robot["properties"]["clearance_m"]["maximum"], 0.2);
  EXPECT_EQ(robot["properties"]["planning"]["enum"], Json::array({"direct", "check", "avoid"}));
  EXPECT_EQ(scene["additionalProperties"], false);
  EXPECT_EQ(scene["properties"]["physics"]["properties"]["step_s"]["exclusiveMinimum"], 0);
  const Json scenario = json_schema(FileKind::kScenario);
  EXPECT_EQ(scenario["required"], Json::array({"description", "scene", "orders"}));
  EXPECT_TRUE(scenario["properties"]["expect"]["properties"].contains("job_s"));
}

}  // namespace
}  // namespace aprsim::client
