#pragma once

#include <map>
#include <string>
#include <string_view>

#include "world/base/result.hpp"

namespace aprsim::web {

/// A file as it is served.
struct Asset {
  std::string type;       ///< Content-Type
  std::string etag;       ///< quoted, of the plain body
  std::string gzip_etag;  ///< quoted, of the compressed body
  std::string body;
  std::string gzip;  ///< compressed body; empty = none
};

/// All files that the web listener serves, read once at the start. Requests select entries of this
/// table only, so no path reaches another file. Thread: any, once filled.
class AssetTable {
 public:
  /// Adds the regular files of a directory by name, without subdirectories. NAME.gz becomes the
  /// compressed body of NAME; index.html is served as "/" too. Errors: kNotFound.
  [[nodiscard]] Result<void> add_directory(const std::string& directory);
  /// Adds the regular files of a directory and of those below it, with `prefix` before their paths,
  /// and index.html as `prefix` as well. Links to other directories are not followed. Errors:
  /// kNotFound.
  [[nodiscard]] Result<void> add_tree(const std::string& prefix, const std::string& directory);
  /// Adds one file. `path` begins with "/". Errors: kNotFound.
  [[nodiscard]] Result<void> add_file(const std::string& path, const std::string& file);
  void add(const std::string& path, std::string type, std::string body);

  /// Asset with this path; null where there is none.
  [[nodiscard]] const Asset* find(std::string_view path) const;

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

}  // namespace aprsim::web
