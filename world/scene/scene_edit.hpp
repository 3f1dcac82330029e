#pragma once

#include <string>

#include "world/api/values/pose.hpp"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

/// Scenes made of others by changes of their text, which are checked as a file is; whether things
/// are in each other's way is not, as they are elsewhere by now.
namespace aprsim::scene {

/// The scene with one more gear or tray of a type, the last one of its kind.
[[nodiscard]] Result<Scene> with_body(const Scene& scene, const std::string& type,
                                      const std::string& name, const Pose& X_WB);

/// The scene with another value under the path of keys; a list's entry is named. Errors:
/// kInvalidArgument for values that a running cell cannot change.
[[nodiscard]] Result<Scene> with_value(const Scene& scene, const std::string& path,
                                       const std::string& value);

}  // namespace aprsim::scene
