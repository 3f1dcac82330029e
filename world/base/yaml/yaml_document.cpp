#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::yaml {

using detail::Value;

namespace {

/// The value at the next key of a path; creates it if absent.
Value& child(Value& parent, const std::string& key, const detail::Mark& mark) {
  if (detail::Entry* entry = parent.find(key)) return entry->value;
  parent.entries.push_back({key, mark, Value{.mark = mark}});
  return parent.entries.back().value;
}

/// Whether `key` is `whole` or a part of it.
bool is_within(const std::string& key, const std::string& whole) {
  return key.starts_with(whole) &&
         (key.size() == whole.size() || key[whole.size()] == '.' || key[whole.size()] == '[');
}

}  // namespace

void detail::Context::add(Error added) {
  if (!error) error = added;
  if (!collects || std::ranges::find(mistyped, added.field) != mistyped.end()) return;
  const bool follows = std::ranges::any_of(errors, [&](const Error& other) {
    return is_within(other.field, added.field) || is_within(added.field, other.field);
  });
  if (!follows) errors.push_back(std::move(added));
}

Document::Document(Value root) : context_(std::make_unique<detail::Context>()) {
  context_->root = std::move(root);
}

Document::~Document() = default;
Document::Document(Document&&) noexcept = default;
Document& Document::operator=(Document&&) noexcept = default;

Result<std::string> read_text(const std::string& path) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) {
    return fail(ErrorCode::kNotFound, "", path + ": found no such file, expected a YAML file");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, status);
  if (!status && size > kMaxBytes) {
    return fail(ErrorCode::kInvalidArgument, "",
                path + ": found " + std::to_string(size) + " bytes, expected at most " +
                    std::to_string(kMaxBytes));
  }
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (size > 0 && !(text << in.rdbuf())) {
    return fail(ErrorCode::kNotFound, "",
                path +
                    ": found a file that cannot be read, expected to "
                    "read it");
  }
  return text.str();
}

Result<Document> Document::from_file(const std::string& path) {
  const auto text = read_text(path);
  if (!text) return tl::unexpected(text.error());
  return from_text(*text, path);
}

Result<Document> Document::from_text(const std::string& text, const std::string& source) {
  auto root = detail::parse(text, source);
  if (!root) return tl::unexpected(std::move(root.error()));
  return Document(std::move(*root));
}

Document Document::recorded(KeyRecorder& recorder) {
  Document document{Value{}};
  document.context_->recorder = &recorder;
  return document;
}

Document Document::from_tree(Value root) { return Document(std::move(root)); }

Node Document::root() const { return {context_.get(), &context_->root, &context_->root, ""}; }

const std::optional<Error>& Document::error() const { return context_->error; }

bool Document::is_recorded() const { return context_->recorder != nullptr; }

void Document::collect_errors() { context_->collects = true; }

const std::vector<Error>& Document::errors() const { return context_->errors; }

Result<void> Document::set(std::string_view path, const std::string& text,
                           const std::string& source) {
  auto parsed = detail::parse(text, source);
  if (!parsed) return tl::unexpected(std::move(parsed.error()));
  // An IPv6 address such as "::" ends like a key without a value.
  if (text.ends_with(':') && parsed->kind == Value::Kind::kMap && parsed->entries.size() == 1 &&
      parsed->entries.front().value.kind == Value::Kind::kNull) {
    parsed->kind = Value::Kind::kScalar;
    parsed->scalar = text;
    parsed->entries.clear();
  }
  Value* value = &context_->root;
  std::istringstream keys{std::string(path)};
  std::string walked;
  for (std::string key; std::getline(keys, key, '.');) {
    if (key.empty() || value->kind == Value::Kind::kScalar || value->kind == Value::Kind::kList) {
      return fail(ErrorCode::kInvalidArgument, std::string(path),
                  source + ": " + std::string(path) + ": found " +
                      (key.empty() ? "an empty key" : "no map at \"" + walked + "\"") +
                      ", expected keys joined by dots");
    }
    value->kind = Value::Kind::kMap;
    value = &child(*value, key, parsed->mark);
    walked += (walked.empty() ? "" : ".") + key;
  }
  if (value == &context_->root) {
    return fail(ErrorCode::kInvalidArgument, "", source + ": found no key, expected KEY=VALUE");
  }
  *value = std::move(*parsed);
  return {};
}

}  // namespace aprsim::yaml
