#pragma once

#include <memory>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/base/result.hpp"
#include "world/cell/world.hpp"

namespace aprsim::world {

/// Changes the scene of a running cell. For values and new bodies it builds another world
/// from the edited scene, which adopts time, robots and bodies of the present one. Thread: the
/// world's.
class SceneEditor {
 public:
  /// `world` must outlive this; it may point to another world after apply().
  explicit SceneEditor(std::unique_ptr<World>& world) : world_(world) {}

  /// Errors: as for a scene file; kNotFound for an unknown name, kFailedPrecondition for a lost
  /// body. Nothing has changed then.
  [[nodiscard]] Result<void> apply(const api::SceneCommand& command);

 private:
  [[nodiscard]] Result<void> edit(const api::SetSceneValue& set);
  [[nodiscard]] Result<void> edit(const api::SpawnBody& spawn);
  [[nodiscard]] Result<void> edit(const api::MoveBody& move);
  [[nodiscard]] Result<void> edit(const api::RemoveBody& remove);
  void replace_by(std::unique_ptr<World> next);
  void report(const std::string& name, std::string text);

  std::unique_ptr<World>& world_;
};

/// Applies any command but the simulation's own to a world, which may be another one afterwards.
[[nodiscard]] Result<void> apply_command(std::unique_ptr<World>& world, api::Ticket ticket,
                                         const api::Command& command);

}  // namespace aprsim::world
