#include "clients/aprsim/files/file_format.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "clients/aprsim/files/comment_lines.hpp"
#include "clients/aprsim/files/json_schema.hpp"
#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::client {
namespace {

using yaml::KeySchema;
using yaml::detail::Entry;
using yaml::detail::Value;

constexpr std::size_t kColumns = 100;

bool is_leaf(const Value& value) {
  return value.kind == Value::Kind::kScalar || value.kind == Value::Kind::kNull;
}

/// As it is where that reads as the same, else in double quotes.
std::string leaf_text(const Value& value, bool in_braces) {
  const std::string& plain = value.scalar;
  const bool is_plain =
      value.kind == Value::Kind::kScalar && !value.quoted && !plain.empty() &&
      !plain.ends_with(':') && plain.find(": ") == std::string::npos &&
      plain.find(" #") == std::string::npos && plain.find_first_of("\n\t") == std::string::npos &&
      std::string_view("-?:,[]{}#&*!|>'\"%@`").find(plain.front()) == std::string_view::npos &&
      (!in_braces || plain.find_first_of(",[]{}\"") == std::string::npos);
  if (is_plain) return plain;
  std::string text = yaml::detail::write(value);
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

/// Entries in the order of the known keys; names of the file's own keep theirs.
std::vector<const Entry*> ordered(const Value& map, const KeySchema* schema) {
  std::vector<const Entry*> out;
  for (const Entry& entry : map.entries) out.push_back(&entry);
  if (schema == nullptr) return out;
  const auto rank = [&](const Entry* entry) {
    const auto found = std::ranges::find(schema->keys, entry->key, &yaml::KeyEntry::key);
    return found - schema->keys.begin();
  };
  std::ranges::stable_sort(out, {}, rank);
  return out;
}

const KeySchema* below(const KeySchema* schema, const std::string& key) {
  if (schema == nullptr) return nullptr;
  if (const yaml::KeyEntry* entry = schema->find(key)) return &entry->value;
  return schema->values.empty() ? nullptr : &schema->values.front();
}

const KeySchema* item_of(const KeySchema* schema) {
  return schema == nullptr || schema->items.empty() ? nullptr : &schema->items.front();
}

std::string key_text(const std::string& key) {
  return leaf_text({.kind = Value::Kind::kScalar, .scalar = key}, true);
}

/// The value in braces, in one line.
std::string flow_text(const Value& value, const KeySchema* schema) {
  if (is_leaf(value)) return leaf_text(value, true);
  std::string out;
  for (const Value& item : value.items) {
    out += (out.empty() ? "" : ", ") + flow_text(item, item_of(schema));
  }
  for (const Entry* entry : ordered(value, schema)) {
    out += (out.empty() ? "" : ", ") + key_text(entry->key) + ": " +
           flow_text(entry->value, below(schema, entry->key));
  }
  return value.kind == Value::Kind::kList ? '[' + out + ']' : '{' + out + '}';
}

/// Lines of at most kColumns, broken after commas where it can be; `column` is that of the value.
std::string wrapped(const std::string& text, std::size_t column, std::size_t indent) {
  std::string out;
  std::size_t at = column, begin = 0;
  char quote = 0;
  const auto put = [&](std::size_t end) {
    const std::string part = text.substr(begin, end - begin);
    const std::size_t length = part.size() - (part.ends_with(' ') ? 1 : 0);
    const bool fits = at + length <= kColumns || begin == 0;
    if (!fits) {
      while (out.ends_with(' ')) out.pop_back();
      out += '\n' + std::string(indent, ' ');
      at = indent;
    }
    out += part;
    at += part.size();
    begin = end;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"' && (i == 0 || text[i - 1] != '\\')) quote = quote == 0 ? '"' : '\0';
    if (text[i] == ',' && quote == 0 && i + 1 < text.size()) put(i + 2);
  }
  put(text.size());
  return out;
}

/// Writes one text again. Lines are numbered from 0.
class Formatter {
 public:
  explicit Formatter(std::vector<SourceLine> lines)
      : lines_(std::move(lines)), used_(lines_.size(), false) {}

  std::string format(const Value& root, const KeySchema& schema) {
    write_header();
    if (root.kind == Value::Kind::kMap) write_map(root, &schema, 0, false);
    // Comments after the last value.
    write_comments(lines_.size(), 0);
    while (out_.ends_with("\n\n")) out_.pop_back();
    return std::move(out_);
  }

 private:
  static std::size_t line_of(const yaml::detail::Mark& mark) {
    return static_cast<std::size_t>(mark.line) - 1;
  }

  [[nodiscard]] bool is_flow(const Value& value) const {
    const std::size_t line = line_of(value.mark);
    const auto column = static_cast<std::size_t>(value.mark.column) - 1;
    if (line >= lines_.size() || column >= lines_[line].content.size()) return true;
    const char c = lines_[line].content[column];
    return c == '{' || c == '[';
  }

  /// A comment at the beginning that ends with an empty line.
  void write_header() {
    std::size_t end = 0;
    for (std::size_t i = 0; i < lines_.size() && lines_[i].content.empty(); ++i) {
      if (lines_[i].comment.empty()) end = i + 1;
    }
    write_comments(end, 0);
    if (!out_.empty() && !out_.ends_with("\n\n")) out_ += '\n';
  }

  /// Comments and empty lines not yet written that stand right above a line.
  void write_comments(std::size_t line, std::size_t indent) {
    std::size_t begin = line;
    while (begin > 0 && !used_[begin - 1] && lines_[begin - 1].content.empty()) --begin;
    for (std::size_t i = begin; i < line; ++i) {
      used_[i] = true;
      if (!lines_[i].comment.empty()) {
        out_ += std::string(indent, ' ') + lines_[i].comment + '\n';
        opened_ = false;
      } else if (!out_.empty() && !out_.ends_with("\n\n") && !opened_) {
        out_ += '\n';
      }
    }
    opened_ = false;
  }

  /// The comment beside the content of a line.
  std::string comment_beside(std::size_t line) {
    if (line >= lines_.size() || lines_[line].content.empty() || used_[line]) return "";
    used_[line] = true;
    return lines_[line].comment.empty() ? "" : "  " + lines_[line].comment;
  }

  /// Last line of a value, from its deepest last part.
  [[nodiscard]] std::size_t last_line(const Value& value) const {
    std::size_t last = line_of(value.mark);
    for (const Value& item : value.items) last = std::max(last, last_line(item));
    for (const Entry& entry : value.entries) {
      last = std::max({last, line_of(entry.mark), last_line(entry.value)});
    }
    return last;
  }

  /// A value in one piece, with the comment of its last line.
  void write_inline(const Value& value, const KeySchema* schema, std::size_t key_line,
                    std::size_t indent) {
    const std::size_t newline = out_.rfind('\n');
    const std::size_t column = out_.size() - (newline == std::string::npos ? 0 : newline + 1);
    out_ += is_leaf(value) ? leaf_text(value, false)
                           : wrapped(flow_text(value, schema), column, indent + 1);
    std::string comment;
    for (std::size_t line = key_line; line <= std::max(key_line, last_line(value)); ++line) {
      const std::string beside = comment_beside(line);
      if (!beside.empty()) comment = beside;
    }
    out_ += comment + '\n';
  }

  void write_value(const Value& value, const KeySchema* schema, std::size_t key_line,
                   std::size_t indent) {
    if (is_leaf(value) || is_flow(value)) {
      out_ += ' ';
      return write_inline(value, schema, key_line, indent);
    }
    const bool same_line = line_of(value.mark) == key_line;
    out_ += (same_line ? "" : comment_beside(key_line)) + '\n';
    opened_ = true;
    if (value.kind == Value::Kind::kMap) return write_map(value, schema, indent, false);
    write_list(value, schema, indent);
  }

  void write_map(const Value& map, const KeySchema* schema, std::size_t indent, bool in_item) {
    const std::vector<const Entry*> entries = ordered(map, schema);
    // Comments above an entry belong to it wherever it goes; those of the first are above the item.
    bool placed = in_item;
    for (const Entry* entry : entries) {
      const std::size_t line = line_of(entry->mark);
      if (!placed) write_comments(line, indent);
      if (!placed) out_ += std::string(indent, ' ');
      placed = false;
      out_ += key_text(entry->key) + ':';
      write_value(entry->value, below(schema, entry->key), line, indent + 2);
    }
  }

  void write_list(const Value& list, const KeySchema* schema, std::size_t indent) {
    for (const Value& item : list.items) {
      write_comments(line_of(item.mark), indent);
      if (item.kind == Value::Kind::kMap && !is_flow(item)) {
        write_comments(line_of(ordered(item, item_of(schema)).front()->mark), indent);
      }
      out_ += std::string(indent, ' ') + "- ";
      if (item.kind == Value::Kind::kMap && !is_flow(item)) {
        write_map(item, item_of(schema), indent + 2, true);
      } else {
        write_inline(item, item_of(schema), line_of(item.mark), indent + 2);
      }
    }
  }

  std::vector<SourceLine> lines_;
  std::vector<bool> used_;
  bool opened_ = false;  // a map or list has just begun
  std::string out_;
};

std::vector<std::string> comments_of(const std::string& text) {
  std::vector<std::string> out;
  for (const SourceLine& line : split_comments(text)) {
    if (!line.comment.empty()) out.push_back(line.comment);
  }
  std::ranges::sort(out);
  return out;
}

bool same(const Value& a, const Value& b) {
  if (a.kind != b.kind || a.scalar != b.scalar || a.items.size() != b.items.size() ||
      a.entries.size() != b.entries.size()) {
    return false;
  }
  for (std::size_t i = 0; i < a.items.size(); ++i) {
    if (!same(a.items[i], b.items[i])) return false;
  }
  return std::ranges::all_of(a.entries, [&](const Entry& entry) {
    const Entry* other = b.find(entry.key);
    return other != nullptr && same(entry.value, other->value);
  });
}

}  // namespace

Outcome<std::string> format_file(const FoundFile& file) {
  const auto root = yaml::detail::parse(file.text, file.path);
  if (!root) return failed(FailureKind::kUsage, root.error().message);
  Formatter formatter(split_comments(file.text));
  std::string text = formatter.format(*root, keys_of(file.kind));
  // Nothing may be lost, whatever the file looks like.
  const auto again = yaml::detail::parse(text, file.path);
  if (!again || !same(*root, *again) || comments_of(text) != comments_of(file.text)) {
    return failed(FailureKind::kUsage,
                  file.path +
                      ": found a form that formatting would not keep, expected no comments within "
                      "braces and no blocks of literal text");
  }
  return text;
}

}  // namespace aprsim::client
