#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::yaml {
class KeyRecorder;
}

/// The parsed form behind yaml_reader.hpp, also for files that are edited and written again.
namespace aprsim::yaml::detail {

struct Mark {
  std::shared_ptr<const std::string> source;  ///< file name or other origin of the text
  int line = 1, column = 1;                   ///< counted from 1
  [[nodiscard]] std::string text() const;     ///< SOURCE:LINE:COLUMN
};

struct Entry;

struct Value {
  enum class Kind { kNull, kScalar, kList, kMap };
  Kind kind = Kind::kNull;
  Mark mark;
  std::string scalar;
  bool quoted = false;  ///< a quoted scalar is text even if it looks like a number
  std::vector<Value> items;
  std::vector<Entry> entries;

  [[nodiscard]] const Entry* find(std::string_view key) const;
  [[nodiscard]] Entry* find(std::string_view key);
};

struct Entry {
  std::string key;
  Mark mark;  ///< of the key
  Value value;
};

/// The tree of one document and the errors met while reading it.
struct Context {
  Value root;
  std::optional<Error> error;         ///< the first
  bool collects = false;              ///< whether `errors` is filled
  std::vector<Error> errors;          ///< all that do not follow from others
  std::vector<std::string> mistyped;  ///< keys that an unknown key was probably meant as
  KeyRecorder* recorder = nullptr;    ///< of a document without a tree

  void add(Error added);
};

/// Parses one YAML document. Refused: syntax errors, several documents, aliases and tags, keys that
/// are not scalars or occur twice, more than 1000 keys in a map, 32 levels or 200 000 values.
[[nodiscard]] Result<Value> parse(const std::string& text, const std::string& source);

/// Writes the tree as YAML that reads as the same tree; places and comments are lost.
[[nodiscard]] std::string write(const Value& root);
/// A number as a scalar that reads as the same number.
[[nodiscard]] Value scalar(double number);
/// A list of such scalars.
[[nodiscard]] Value list(std::initializer_list<double> numbers);

}  // namespace aprsim::yaml::detail
