#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::web {

/// A file that has types only.
struct TypesFile {
  std::string file;  ///< as a scene names it
  std::string text;  ///< YAML
};

/// The text of a scene, to be edited.
struct SceneSource {
  std::string text;              ///< YAML
  bool as_written = false;       ///< with its comments; else composed from what was read
  std::vector<TypesFile> types;  ///< that a scene may name
};

/// The cell of a scene that is edited, as it begins.
struct SceneDraft {
  struct Model {
    std::string robot;  ///< its name
    std::string file;   ///< absolute path
    std::string text;   ///< URDF
  };
  /// Slots of a tray in which a robot can grip.
  struct Reach {
    std::size_t robot = 0, body = 0;  ///< numbers in the cell
    std::vector<std::size_t> slots;   ///< numbers in the tray
  };
  api::SnapshotPtr snapshot;
  std::vector<Model> models;   ///< of all its robots
  std::vector<Reach> reaches;  ///< one for each robot and tray; empty = not known
};

/// Scenes that are edited beside the running cell, which they do not change.
class SceneDrafts {
 public:
  virtual ~SceneDrafts() = default;

  /// The text from which a cell of this daemon was made. Thread: any.
  [[nodiscard]] virtual SceneSource source_of(const api::CellDescription& cell) = 0;

  using Answer = std::function<void(Result<SceneDraft>)>;
  /// Builds the cell of a text and calls `answer`, once, from a thread of its own or at once, here.
  /// `name` is the scene's. Errors: as of a scene file, without its place in the file system;
  /// kUnavailable when too many wait or the daemon ends. Thread: any.
  virtual void build(std::string text, std::string name, Answer answer) = 0;
};

}  // namespace aprsim::web
