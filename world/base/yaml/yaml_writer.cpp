#include <algorithm>
#include <array>
#include <charconv>

#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::yaml::detail {
namespace {

/// Writes a scalar so that it reads as the same.
std::string scalar_text(const std::string& text, bool quoted) {
  const bool plain = !quoted && !text.empty() && text.front() != ' ' && text.back() != ' ' &&
                     text.find_first_of(",[]{}#:&*!|>'\"%@`\\\n\t") == std::string::npos &&
                     (text.front() != '-' || text.size() > 1) && text.front() != '?';
  if (plain) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? std::string("\\n") : c == '\t' ? std::string("\\t") : std::string(1, c);
  }
  return out + '"';
}

bool is_leaf(const Value& value) {
  return value.kind == Value::Kind::kScalar || value.kind == Value::Kind::kNull;
}

/// Whether the value fits in one line: it holds at most lists of scalars.
bool is_short(const Value& value) {
  return is_leaf(value) ||
         (value.kind == Value::Kind::kList && std::ranges::all_of(value.items, is_leaf)) ||
         (value.kind == Value::Kind::kMap && value.entries.empty());
}

std::string short_text(const Value& value) {
  if (value.kind == Value::Kind::kNull) return "~";
  if (value.kind == Value::Kind::kScalar) return scalar_text(value.scalar, value.quoted);
  if (value.kind == Value::Kind::kMap) return "{}";
  std::string out;
  for (const Value& item : value.items) out += (out.empty() ? "" : ", ") + short_text(item);
  return '[' + out + ']';
}

void write_block(const Value& value, std::size_t indent, bool first_is_placed, std::string& out) {
  bool placed = first_is_placed;
  const auto begin = [&] {
    if (!placed) out += std::string(indent, ' ');
    placed = false;
  };
  if (value.kind == Value::Kind::kList) {
    for (const Value& item : value.items) {
      begin();
      out += "- ";
      if (is_short(item)) {
        out += short_text(item) + '\n';
      } else {
        write_block(item, indent + 2, true, out);
      }
    }
    return;
  }
  for (const Entry& entry : value.entries) {
    begin();
    out += scalar_text(entry.key, false) + ':';
    if (is_short(entry.value)) {
      out += ' ' + short_text(entry.value) + '\n';
    } else {
      out += '\n';
      write_block(entry.value, indent + 2, false, out);
    }
  }
}

}  // namespace

std::string write(const Value& root) {
  if (is_short(root)) return short_text(root) + '\n';
  std::string out;
  write_block(root, 0, false, out);
  return out;
}

Value scalar(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {.kind = Value::Kind::kScalar, .scalar = std::string(text.data(), end)};
}

Value list(std::initializer_list<double> numbers) {
  Value out{.kind = Value::Kind::kList};
  for (const double number : numbers) out.items.push_back(scalar(number));
  return out;
}

}  // namespace aprsim::yaml::detail
