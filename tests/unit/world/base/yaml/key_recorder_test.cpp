#include "world/base/yaml/key_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include <gtest/gtest.h>

namespace aprsim::yaml {
namespace {

KeySchema recorded(const std::function<void(const Node&)>& read) {
  KeyRecorder recorder;
  const Document document = Document::recorded(recorder);
  for (int run = 0; run < 200; ++run) {
    recorder.begin_run();
    read(document.root());
    recorder.end_run();
    EXPECT_FALSE(document.error());
  }
  return recorder.schema();
}

const KeySchema& at(const KeySchema& schema, const std::string& key) {
  const KeyEntry* entry = schema.find(key);
  if (entry == nullptr) throw std::out_of_range(key);
  return entry->value;
}

TEST(KeyRecorder, KnowsTypesLimitsAndDefaults) {
  const KeySchema schema = recorded([](const Node& root) {
    const Map keys = root.map({"length_m", "share", "count", "flag", "word", "name", "xy_m"});
    static_cast<void>(keys["length_m"].number(above(0)));
    static_cast<void>(keys["share"].number_or(0.25, between(0, 1)));
    static_cast<void>(keys["count"].integer_or(3, 1, 9));
    static_cast<void>(keys["flag"].boolean_or(true));
    static_cast<void>(keys["word"].word_or(1, {"one", "two"}));
    static_cast<void>(keys["name"].text());
    static_cast<void>(keys["xy_m"].numbers<2>(between(-5, 5)));
  });
  ASSERT_EQ(schema.keys.size(), 7U);
  EXPECT_EQ(schema.keys.front().key, "length_m");
  EXPECT_EQ(at(schema, "length_m").number->min, 0);
  EXPECT_TRUE(at(schema, "length_m").number->open_min);
  EXPECT_TRUE(at(schema, "length_m").is_required);
  EXPECT_EQ(at(schema, "share").number->max, 1);
  EXPECT_EQ(at(schema, "share").fallback, "0.25");
  EXPECT_FALSE(at(schema, "share").is_required);
  EXPECT_EQ(at(schema, "count").integer->max, 9);
  EXPECT_EQ(at(schema, "count").fallback, "3");
  EXPECT_TRUE(at(schema, "flag").is_boolean);
  EXPECT_EQ(at(schema, "word").words, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(at(schema, "word").fallback, "two");
  EXPECT_TRUE(at(schema, "name").is_text && at(schema, "name").words.empty());
  EXPECT_EQ(at(schema, "xy_m").min_items, 2U);
  EXPECT_EQ(at(schema, "xy_m").max_items, 2U);
  EXPECT_EQ(at(schema, "xy_m").items.front().number->min, -5);
}

TEST(KeyRecorder, KeepsOnlyWhatHoldsForEveryFile) {
  const KeySchema schema = recorded([](const Node& root) {
    const Map keys = root.map({"top", "bottom", "force", "air"});
    const double top = keys["top"].number(above(0));
    static_cast<void>(keys["bottom"].number_or(top / 2, {.min = 0, .max = top, .open_min = true}));
    if (!keys["air"]) static_cast<void>(keys["force"].number());
    if (const Node air = keys["air"]) static_cast<void>(air.map({"bar"})["bar"].number());
  });
  EXPECT_FALSE(std::isfinite(at(schema, "bottom").number->max));
  EXPECT_EQ(at(schema, "bottom").number->min, 0);
  EXPECT_FALSE(at(schema, "bottom").fallback);
  EXPECT_FALSE(at(schema, "force").is_required) << "not beside air";
  EXPECT_FALSE(at(schema, "air").is_required);
  EXPECT_TRUE(at(at(schema, "air"), "bar").is_required) << "within air";
}

TEST(KeyRecorder, FollowsListsNamesAndForms) {
  const std::vector<std::string> measures = {"time", "parts"};
  const KeySchema schema = recorded([&](const Node& root) {
    const Map keys = root.map({"things", "types", "focal", "expect"});
    for (const Node& item : keys["things"].items()) {
      static_cast<void>(item.map({"name"})["name"].text());
    }
    for (const auto& [name, node] : keys["types"].entries()) {
      static_cast<void>(node.map({"size"})["size"].number());
    }
    if (const Node focal = keys["focal"]) {
      static_cast<void>(focal.is_list() ? focal.numbers<2>()[0] : focal.number());
    }
    keys["expect"].note_names(measures);
    for (const auto& [name, node] : keys["expect"].entries()) {
      EXPECT_NE(std::ranges::find(measures, name), measures.end());
      static_cast<void>(node.number());
    }
  });
  EXPECT_TRUE(at(at(schema, "things").items.front(), "name").is_required);
  EXPECT_TRUE(at(at(schema, "types").values.front(), "size").number);
  EXPECT_TRUE(at(schema, "focal").number);
  EXPECT_EQ(at(schema, "focal").items.size(), 1U);
  EXPECT_EQ(at(schema, "expect").names, measures);
}

std::vector<std::string> errors_in(const std::string& text) {
  auto document = Document::from_text(text, "f");
  EXPECT_TRUE(document.has_value());
  document->collect_errors();
  const Map keys = document->root().map({"mass_kg", "size_m", "pose", "count"});
  static_cast<void>(keys["mass_kg"].number(kPositive));
  static_cast<void>(keys["count"].integer_or(1, 1, 5));
  const Map pose = keys["pose"].map({"x", "y"});
  static_cast<void>(pose["x"].number());
  static_cast<void>(pose["y"].number());
  keys["pose"].error("a pose that does not fit", "another");
  std::vector<std::string> fields;
  for (const Error& error : document->errors()) fields.push_back(error.field);
  return fields;
}

using Fields = std::vector<std::string>;

TEST(CollectedErrors, AllAreKeptButThoseThatFollowFromOthers) {
  EXPECT_EQ(errors_in("mass_kg: -1\ncount: 9\npose: {x: 1, y: 2}\n"),
            (Fields{"mass_kg", "count", "pose"}));
  EXPECT_EQ(errors_in("mass_kg: -1\npose: {x: one, y: two}\n"),
            (Fields{"mass_kg", "pose.x", "pose.y"}))
      << "the pose does not fit since its parts do not";
  EXPECT_EQ(errors_in("mas_kg: 1\npose: {x: 1, y: 2}\n"), (Fields{"mas_kg", "pose"}))
      << "mass_kg is missing since it is mistyped";
  EXPECT_EQ(errors_in("mas_kg: 1\ncuont: 2\npose: 3\n"), (Fields{"mas_kg", "cuont", "pose"}));
}

}  // namespace
}  // namespace aprsim::yaml
