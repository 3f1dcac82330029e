#include <algorithm>
#include <set>
#include <sstream>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::yaml::detail {
namespace {

/// Far above the needs of a cell, and still read in negligible time.
constexpr std::size_t kMaxDepth = 32, kMaxKeys = 1000, kMaxValues = 200'000;

/// Leaves the parser from inside an event; never leaves this file.
struct Refused {
  Error error;
};

Error error_at(const Mark& mark, const std::string& key, const std::string& what) {
  return {ErrorCode::kInvalidArgument, key,
          mark.text() + ": " + (key.empty() ? "" : key + ": ") + what};
}

/// Builds the tree from the parser's events.
class Builder : public YAML::EventHandler {
 public:
  explicit Builder(std::shared_ptr<const std::string> source) : source_(std::move(source)) {}

  Value release_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    attach(make(Value::Kind::kNull, mark));
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Refused{error_at(at(mark), "", "found an alias (*name), expected the value itself")};
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    refuse_anchor(mark, anchor);
    if (tag != "?" && tag != "!" && !tag.empty()) refuse_tag(mark, tag);
    Value value = make(Value::Kind::kScalar, mark);
    value.scalar = text;
    value.quoted = tag == "!";
    attach(std::move(value));
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Value::Kind::kList, mark, tag, anchor);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Value::Kind::kMap, mark, tag, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    Value value;
    std::optional<Value> key;  ///< of a map: read and waiting for its value
    std::set<std::string> keys = {};
  };

  Mark at(const YAML::Mark& mark) const { return {source_, mark.line + 1, mark.column + 1}; }

  Value make(Value::Kind kind, const YAML::Mark& mark) const {
    Value value;
    value.kind = kind;
    value.mark = at(mark);
    return value;
  }

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor == YAML::NullAnchor) return;
    throw Refused{error_at(at(mark), "", "found an anchor (&name), expected a plain value")};
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    throw Refused{error_at(at(mark), "", "found the tag " + tag + ", expected a plain value")};
  }

  void open(Value::Kind kind, const YAML::Mark& mark, const std::string& tag,
            YAML::anchor_t anchor) {
    refuse_anchor(mark, anchor);
    if (tag != "?" && tag != "!" && !tag.empty()) refuse_tag(mark, tag);
    levels_.push_back({make(kind, mark), std::nullopt});
    limit(at(mark), levels_.size(), kMaxDepth, "levels of lists and maps");
  }

  void close() {
    Value value = std::move(levels_.back().value);
    levels_.pop_back();
    attach(std::move(value));
  }

  static void limit(const Mark& mark, std::size_t count, std::size_t most, const char* what) {
    if (count <= most) return;
    throw Refused{error_at(mark, "",
                           "found " + std::to_string(count) + " " + what + ", expected at most " +
                               std::to_string(most))};
  }

  void attach(Value value) {
    limit(value.mark, ++values_, kMaxValues, "values");
    if (levels_.empty()) {
      root_ = std::move(value);
      return;
    }
    Level& level = levels_.back();
    if (level.value.kind == Value::Kind::kList) {
      level.value.items.push_back(std::move(value));
    } else if (!level.key) {
      set_key(level, std::move(value));
    } else {
      level.value.entries.push_back(
          {std::move(level.key->scalar), std::move(level.key->mark), std::move(value)});
      level.key.reset();
    }
  }

  static void set_key(Level& level, Value key) {
    if (key.kind != Value::Kind::kScalar || key.scalar.empty()) {
      throw Refused{error_at(key.mark, "", "found a key that is not a word, expected a name")};
    }
    if (!level.keys.insert(key.scalar).second) {
      const Entry* first = level.value.find(key.scalar);
      throw Refused{error_at(key.mark, key.scalar,
                             "found a second time, expected once (first at line " +
                                 std::to_string(first->mark.line) + ")")};
    }
    limit(key.mark, level.keys.size(), kMaxKeys, "keys in a map");
    level.key = std::move(key);
  }

  std::shared_ptr<const std::string> source_;
  std::vector<Level> levels_;
  std::size_t values_ = 0;
  Value root_;
};

}  // namespace

std::string Mark::text() const {
  return (source ? *source : std::string("?")) + ":" + std::to_string(line) + ":" +
         std::to_string(column);
}

const Entry* Value::find(std::string_view key) const {
  const auto it =
      std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
  return it == entries.end() ? nullptr : &*it;
}

Entry* Value::find(std::string_view key) {
  return const_cast<Entry*>(std::as_const(*this).find(key));
}

Result<Value> parse(const std::string& text, const std::string& source) {
  const auto name = std::make_shared<const std::string>(source);
  Builder builder(name);
  try {
    std::istringstream in(text);
    YAML::Parser parser(in);
    if (!parser.HandleNextDocument(builder)) return Value{.mark = {name, 1, 1}};
    Value root = builder.release_root();
    Builder second(name);
    if (parser.HandleNextDocument(second)) {
      return tl::unexpected(error_at(second.release_root().mark, "",
                                     "found a second document, expected one in the file"));
    }
    return root;
  } catch (const Refused& refused) {
    return tl::unexpected(refused.error);
  } catch (const YAML::Exception& e) {
    const Mark mark{name, e.mark.is_null() ? 1 : e.mark.line + 1,
                    e.mark.is_null() ? 1 : e.mark.column + 1};
    return tl::unexpected(error_at(mark, "", "found text that is not YAML: " + e.msg));
  }
}

}  // namespace aprsim::yaml::detail
