#include "protocols/web/http/asset_table.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace aprsim::web {
namespace {

namespace fs = std::filesystem;

std::string type_of(const fs::path& file) {
  static const std::map<std::string, std::string> kTypes = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".webp", "image/webp"},
      {".json", "application/json"},
      {".txt", "text/plain; charset=utf-8"},
      {".urdf", "application/xml"},
      {".webmanifest", "application/manifest+json"}};
  const auto type = kTypes.find(file.extension().string());
  return type == kTypes.end() ? "application/octet-stream" : type->second;
}

std::optional<std::string> read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return std::nullopt;
  return std::move(text).str();
}

/// Entity tag by FNV-1a; `suffix` distinguishes the encodings of one file.
std::string etag_of(const std::string& body, std::string_view suffix) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : body) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return fmt::format("\"{:016x}{}\"", hash, suffix);
}

}  // namespace

Result<void> AssetTable::add_directory(const std::string& directory) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (!entry.is_regular_file(error) || entry.path().extension() == ".gz") continue;
    const std::string path = "/" + entry.path().filename().string();
    if (auto ok = add_file(path, entry.path().string()); !ok) return ok;
    if (auto packed = read(entry.path().string() + ".gz")) assets_[path].gzip = std::move(*packed);
    if (path == "/index.html") assets_["/"] = assets_[path];
  }
  if (error) {
    return fail(ErrorCode::kNotFound, "web", "cannot read " + directory + ": " + error.message());
  }
  return {};
}

Result<void> AssetTable::add_tree(const std::string& prefix, const std::string& directory) {
  std::error_code error;
  const fs::path root(directory);
  for (fs::recursive_directory_iterator entry(root, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->is_regular_file() || entry->is_symlink()) continue;
    const std::string path = prefix + entry->path().lexically_relative(root).generic_string();
    if (auto ok = add_file(path, entry->path().string()); !ok) return ok;
    if (path == prefix + "index.html") assets_[prefix] = assets_[path];
  }
  if (error) {
    return fail(ErrorCode::kNotFound, "web", "cannot read " + directory + ": " + error.message());
  }
  return {};
}

Result<void> AssetTable::add_file(const std::string& path, const std::string& file) {
  auto body = read(file);
  if (!body) return fail(ErrorCode::kNotFound, "web", "cannot read " + file);
  add(path, type_of(file), std::move(*body));
  return {};
}

void AssetTable::add(const std::string& path, std::string type, std::string body) {
  Asset& asset = assets_[path];
  asset.etag = etag_of(body, "");
  asset.gzip_etag = etag_of(body, "-gzip");
  asset.type = std::move(type);
  asset.body = std::move(body);
}

const Asset* AssetTable::find(std::string_view path) const {
  const auto asset = assets_.find(path);
  return asset == assets_.end() ? nullptr : &asset->second;
}

}  // namespace aprsim::web
