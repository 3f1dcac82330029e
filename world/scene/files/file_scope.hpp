#pragma once

#include <string>
#include <vector>

#include "world/scene/model/scene.hpp"

namespace aprsim::scene {

/// The files that a daemon was started with: absolute paths.
struct KnownFiles {
  std::vector<std::string> types, models;
};
/// Those of a scene.
[[nodiscard]] KnownFiles files_of(const Scene& scene);

/// The directories of the shipped files.
struct ShippedFiles {
  std::string types, models;
};

/// Finds the files of types and models that a scene names: relative to its directory, or shipped.
/// A text from outside may name shipped and known files only: no other path is even looked up.
/// Thread: any.
class FileScope {
 public:
  /// A scene of the user's own: any file. `file` is the scene's.
  FileScope(const std::string& file, ShippedFiles shipped);
  /// A scene from outside. Relative names are as in `file`.
  FileScope(const std::string& file, ShippedFiles shipped, KnownFiles known);

  /// Absolute path of a file of types; empty = none that may be read.
  [[nodiscard]] std::string find_types(const std::string& name) const;
  /// Absolute path of a robot description; empty = none that may be read.
  [[nodiscard]] std::string find_model(const std::string& name) const;
  /// The same beside the scene; empty = it is not there.
  [[nodiscard]] std::string find_model_beside(const std::string& name) const;

  /// Description of the files that a scene may name, for messages.
  [[nodiscard]] std::string expected_types() const;
  [[nodiscard]] std::string expected_model() const;

 private:
  [[nodiscard]] std::string find(const std::string& name, const std::string& directory,
                                 const std::string& shipped,
                                 const std::vector<std::string>& known) const;

  std::string directory_;  ///< of the scene
  ShippedFiles shipped_;
  bool is_limited_ = false;
  KnownFiles known_;
};

}  // namespace aprsim::scene
