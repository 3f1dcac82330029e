#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/files/key_table.hpp"
#include "clients/wires/outcome.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/model/scene.hpp"

/// Scene and scenario files, read and checked without a daemon.
namespace aprsim::client {

/// Something wrong or doubtful in a file.
struct Problem {
  std::string file;
  int line = 0, column = 0;  ///< counted from 1; 0 = of the whole file
  std::string key;           ///< as in robots[0].base; empty = none
  std::string message;       ///< value found and value expected
  bool is_warning = false;
};

struct CheckedFile {
  std::string file;
  FileKind kind = FileKind::kScene;
  std::vector<Problem> problems;      ///< errors in the order of lines, then warnings
  std::optional<scene::Scene> scene;  ///< of a scene without errors

  [[nodiscard]] std::size_t errors() const;
};

/// A file by the name of a shipped scene or scenario, or by its path. `kind` is kTypes if a scene
/// file has types only. Error: there is no such file, or it cannot be read.
struct FoundFile {
  std::string path, text;
  FileKind kind = FileKind::kScene;
};
[[nodiscard]] Outcome<FoundFile> find_file(FileKind kind, const std::string& name_or_file,
                                           const scene::DataPaths& paths);

/// All errors; without errors, warnings of a scene: bodies that no robot reaches, and types that
/// are defined in the scene itself and not used.
[[nodiscard]] CheckedFile check_file(const FoundFile& found, const scene::DataPaths& paths);

}  // namespace aprsim::client
