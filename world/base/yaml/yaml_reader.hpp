#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "world/base/result.hpp"

/// Strict reading of YAML files. Every value knows its key path and place; whatever does not fit
/// is an error "FILE:LINE:COLUMN: KEY: found ..., expected ...", with Error::field = KEY. The first
/// error sticks to the Document: readers go on with harmless values, and the caller asks once, at
/// the end. Anchors, aliases and tags are refused. Thread: one at a time for each Document.
namespace aprsim::yaml {

namespace detail {
struct Value;
struct Context;
}  // namespace detail

/// Limits of a number; an open end excludes the limit itself.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open_min = false, open_max = false;
  [[nodiscard]] bool holds(double value) const;
  [[nodiscard]] std::string text() const;  ///< " > 0", " in [0, 1]"; empty without limits
};
[[nodiscard]] constexpr Range above(double min) { return {.min = min, .open_min = true}; }
[[nodiscard]] constexpr Range at_least(double min) { return {.min = min}; }
[[nodiscard]] constexpr Range between(double min, double max) { return {.min = min, .max = max}; }
inline constexpr Range kPositive = above(0);
inline constexpr Range kNotNegative = at_least(0);

class KeyRecorder;
class Map;

/// A value, or the place where one is missing. Cheap to copy; valid as long as its Document.
/// Getters without a fallback demand the value; those with one take it when the key is absent.
class Node {
 public:
  [[nodiscard]] explicit operator bool() const { return value_ != nullptr; }
  [[nodiscard]] const std::string& key() const { return key_; }  ///< as in trays[2].xy_m
  [[nodiscard]] std::string where() const;                       ///< FILE:LINE:COLUMN
  [[nodiscard]] bool is_list() const;
  [[nodiscard]] bool is_map() const;

  [[nodiscard]] double number(const Range& range = {}) const;
  [[nodiscard]] double number_or(double fallback, const Range& range = {}) const;
  [[nodiscard]] std::int64_t integer(
      std::int64_t min = 0, std::int64_t max = std::numeric_limits<std::int64_t>::max()) const;
  [[nodiscard]] std::int64_t integer_or(
      std::int64_t fallback, std::int64_t min = 0,
      std::int64_t max = std::numeric_limits<std::int64_t>::max()) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] bool boolean_or(bool fallback) const;
  [[nodiscard]] std::string text() const;  ///< not empty
  [[nodiscard]] std::string text_or(const std::string& fallback) const;

  /// One of the words; the index into `words`.
  [[nodiscard]] std::size_t word(std::span<const std::string_view> words) const;
  [[nodiscard]] std::size_t word(std::initializer_list<std::string_view> words) const {
    return word(std::span(words.begin(), words.size()));
  }
  [[nodiscard]] std::size_t word_or(std::size_t fallback,
                                    std::initializer_list<std::string_view> words) const;

  /// A list of numbers with a length in [min_count, max_count]; always at least min_count values.
  [[nodiscard]] std::vector<double> numbers(std::size_t min_count, std::size_t max_count,
                                            const Range& range = {}) const;
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> numbers(const Range& range = {}) const {
    const std::vector<double> values = numbers(N, N, range);
    std::array<double, N> result{};
    for (std::size_t i = 0; i < N; ++i) result[i] = values[i];
    return result;
  }

  [[nodiscard]] std::vector<Node> items() const;  ///< of a list; none when absent
  [[nodiscard]] std::vector<std::pair<std::string, Node>> entries() const;  ///< same, of a map
  /// A map with no keys but these; the first unknown one is an error that lists them.
  [[nodiscard]] Map map(std::span<const std::string_view> known) const;
  [[nodiscard]] Map map(std::initializer_list<std::string_view> known) const;

  /// Tell a recording the words of text(), or the names of entries(), that the caller accepts.
  void note_words(std::span<const std::string> words) const;
  void note_names(std::span<const std::string> names) const;

  /// Records "found ..., expected ..." at this value, unless the document has an error already.
  void error(const std::string& found, const std::string& expected,
             ErrorCode code = ErrorCode::kInvalidArgument) const;
  /// error() whose "found" part is the value itself.
  void unexpected(const std::string& expected, ErrorCode code = ErrorCode::kInvalidArgument) const;

 private:
  friend class Map;
  friend class Document;
  Node(detail::Context* context, const detail::Value* value, const detail::Value* place,
       std::string key)
      : context_(context), value_(value), place_(place), key_(std::move(key)) {}
  [[nodiscard]] std::string found() const;
  [[nodiscard]] std::vector<double> recorded_numbers(std::size_t min_count, std::size_t max_count,
                                                     const Range& range) const;

  detail::Context* context_;
  const detail::Value* value_;  ///< null: absent
  const detail::Value* place_;  ///< the value, or the nearest one around it
  std::string key_;
};

/// A map whose keys have been checked.
class Map {
 public:
  /// The value of a key, perhaps absent. Throws std::logic_error for a key not among the known.
  [[nodiscard]] Node operator[](std::string_view key) const;
  [[nodiscard]] const Node& node() const { return node_; }

 private:
  friend class Node;
  Map(Node node, std::vector<std::string> known)
      : node_(std::move(node)), known_(std::move(known)) {}
  Node node_;
  std::vector<std::string> known_;
};

/// Largest file.
inline constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

/// Reads the text of a file. Errors: no such file, unreadable, larger than kMaxBytes.
[[nodiscard]] Result<std::string> read_text(const std::string& path);

/// One parsed file.
class Document {
 public:
  /// Errors: no such file, unreadable, larger than 1 MiB, not YAML.
  [[nodiscard]] static Result<Document> from_file(const std::string& path);
  /// `source` takes the place of the file name in messages.
  [[nodiscard]] static Result<Document> from_text(const std::string& text,
                                                  const std::string& source);
  /// A document in which each run of `recorder` finds other keys; see key_recorder.hpp. It never
  /// has an error.
  [[nodiscard]] static Document recorded(KeyRecorder& recorder);
  /// A document that was parsed before, and maybe changed.
  [[nodiscard]] static Document from_tree(detail::Value root);
  ~Document();
  Document(Document&&) noexcept;
  Document& operator=(Document&&) noexcept;

  [[nodiscard]] Node root() const;
  /// Sets the value at a path of keys joined by dots ("modbus.port") from YAML text, creating maps
  /// on the way. `source` names the origin in messages ("--set").
  [[nodiscard]] Result<void> set(std::string_view path, const std::string& text,
                                 const std::string& source);
  [[nodiscard]] const std::optional<Error>& error() const;
  [[nodiscard]] bool is_recorded() const;

  /// Before reading: keeps further errors than the first, too, for errors(). Errors that follow
  /// from others are left out: of values around or within a value with an error, and of a missing
  /// key where an unknown one is nearly the same.
  void collect_errors();
  [[nodiscard]] const std::vector<Error>& errors() const;

 private:
  explicit Document(detail::Value root);
  std::unique_ptr<detail::Context> context_;
};

/// The known word nearest to `word` by edit distance; empty when none is near.
[[nodiscard]] std::string nearest_word(std::string_view word,
                                       const std::vector<std::string>& known);

}  // namespace aprsim::yaml
