#pragma once

#include <string>

#include <gtest/gtest.h>

#include "world/scene/scene_loader.hpp"

namespace aprsim::scene {

/// A directory of its own for each test, gone afterwards.
class SceneFiles : public testing::Test {
 protected:
  SceneFiles();
  ~SceneFiles() override;

  /// Writes a file below the directory and gives its path.
  std::string write(const std::string& name, const std::string& text) const;
  [[nodiscard]] Result<Scene> load(const std::string& path) const;
  /// Copies the shipped scenes with their types.
  void copy_shipped_scenes() const;

  std::string directory_;
};

[[nodiscard]] std::string read_file(const std::string& path);

/// A scene with one of everything; its robot's model is the file arm.urdf beside it.
[[nodiscard]] std::string small_scene();

/// `text` with the first `from` replaced; fails the test when there is none.
[[nodiscard]] std::string replaced(std::string text, const std::string& from,
                                   const std::string& to);

}  // namespace aprsim::scene
