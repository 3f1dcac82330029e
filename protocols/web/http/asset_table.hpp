#pragma once

#include <map>
#include <string>
#include <string_view>

#include "world/base/result.hpp"

namespace aprsim::web {

/// A file as it is served.
struct Asset {
  std::string type;  ///< Content-Type
  std::string etag;  ///< quoted
  std::string body;
  std::string gzip;  ///< the same compressed; empty = not
};

/// All that the web listener serves, read once: a request can name an entry of this table and
/// nothing else, so that no path leads out of it. Thread: any once filled.
class AssetTable {
 public:
  /// Adds the regular files of a directory by their names; NAME.gz goes with NAME, and index.html
  /// is "/" as well. Other directories below are left alone. Errors: kNotFound.
  [[nodiscard]] Result<void> add_directory(const std::string& directory);
  /// Adds the regular files of a directory and of those below it, with `prefix` before their paths,
  /// and index.html as `prefix` as well. Links to other directories are not followed. Errors:
  /// kNotFound.
  [[nodiscard]] Result<void> add_tree(const std::string& prefix, const std::string& directory);
  /// Adds one file. `path` begins with "/". Errors: kNotFound.
  [[nodiscard]] Result<void> add_file(const std::string& path, const std::string& file);
  void add(const std::string& path, std::string type, std::string body);

  /// The asset of a request's target without its query; null when there is none.
  [[nodiscard]] const Asset* find(std::string_view path) const;

 private:
  std::map<std::string, Asset, std::less<>> assets_;
};

}  // namespace aprsim::web
