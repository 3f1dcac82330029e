#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "world/api/ports/move_previews.hpp"
#include "world/api/ports/ports.hpp"
#include "world/runtime/publish/snapshot_slot.hpp"
#include "world/runtime/simulation_core.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::embedded {

/// Acts on the cell between two steps, as programs of clients do. Returns whether it must be called
/// after every step, because it may act again without a call of the cell.
using AfterStep = std::function<bool()>;

/// A cell that its caller steps: a Simulation without thread, clock and queue. It is always paused.
/// A command takes effect when it is submitted. Equal commands at equal steps give the bits of the
/// daemon. Thread: one at a time; several cells are independent.
class EmbeddedCell final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// Throws std::runtime_error as World does.
  EmbeddedCell(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed);

  /// Applies the command. Errors: those of Simulation::submit(); later ones are in the snapshot.
  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  /// Takes the steps that commands have asked for: counted ones, or a run to its end. `after_step`
  /// is called after each; the steps of a cell that is at rest may be taken as one.
  void take_steps(const AfterStep& after_step);

  /// Plans a move without making it. Errors: as of api::MovePreviews.
  [[nodiscard]] Result<api::MovePreview> preview(const api::PreviewRequest& request) const;

  /// Written when something has changed since the last call.
  [[nodiscard]] api::SnapshotPtr latest() const override;
  /// Returns the latest at once: no other thread steps.
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override;
  [[nodiscard]] std::string problem() const override { return core_.control().world_fault(); }

  [[nodiscard]] const api::EventSource& events() const { return core_.events(); }
  [[nodiscard]] const world::World& world() const { return core_.world(); }

 private:
  /// Whether a step is to be taken now.
  [[nodiscard]] bool is_stepping() const;
  void write_snapshot() const;

  world::SimulationCore core_;
  mutable world::SnapshotSlot slot_;
  mutable bool changed_ = true;  ///< since the latest snapshot
  api::Ticket last_ticket_ = 0;
};

}  // namespace aprsim::embedded
