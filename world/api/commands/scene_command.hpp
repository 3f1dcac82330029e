#pragma once

#include <cstddef>
#include <string>
#include <variant>

#include "world/api/values/pose.hpp"

/// Changes of the scene of a running or paused cell. Each is checked like a scene's file and takes
/// effect between two steps; a reset undoes them all, a saved state keeps them.
namespace aprsim::api {

/// Adds a gear or tray to the cell at a pose, or above it by as much as it takes to be clear of
/// all else.
struct SpawnBody {
  std::string type;  ///< of gears or of trays
  std::string name;  ///< that nothing else in the scene has
  Pose X_WB;
};
/// Moves a gear or tray, at rest, in the same way.
struct MoveBody {
  std::string name;
  Pose X_WB;
};
/// Removes a gear or tray: it is lost.
struct RemoveBody {
  std::string name;
};
/// Sets a value of the scene, by the path of its keys: "physics.friction.gear_tray",
/// "gear_types.TYPE.mass_kg", "robots.NAME.vision.position_noise_m". Only values of types,
/// contacts and cameras can be set.
struct SetSceneValue {
  std::string path;
  std::string value;  ///< as in a scene's file
};
using SceneCommand = std::variant<SpawnBody, MoveBody, RemoveBody, SetSceneValue>;

/// Bodies that a cell may have beyond those of the scene as it was loaded; removed ones count until
/// a reset.
inline constexpr std::size_t kMaxAddedBodies = 100;
/// Changes of a cell that runs by the wall clock: a second, and at once.
inline constexpr double kMaxEditsPerSecond = 10, kMaxEditsAtOnce = 20;

inline constexpr std::size_t kMaxSceneText = 64;  ///< bytes of a name
inline constexpr std::size_t kMaxScenePath = 256, kMaxSceneValue = 4096;

}  // namespace aprsim::api
