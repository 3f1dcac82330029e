#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include "world/api/description/cell_description.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::server {

/// The cell as one listener of a robot uses it. Snapshots are the latest as long as the robot is
/// in the cell at the index that the listener knows. Once another scene has other robots, the
/// last one with the robot stays, until move_to() or the listener's end. Commands reach the robot
/// at its present index; they fail where it has gone. Thread: any.
class RobotView final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// `robot`: of the latest snapshot, at this index. Both references outlive the view.
  RobotView(api::CommandSink& sink, const api::SnapshotSource& source, api::SnapshotPtr now,
            int index);

  /// The listener knows the robot at this index from now on; `now` has it there.
  void move_to(int index, api::SnapshotPtr now);

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override;
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override;
  [[nodiscard]] std::string problem() const override { return source_.problem(); }

 private:
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  const std::shared_ptr<const api::CellDescription> first_;
  const api::RobotDescription& robot_;  ///< of that
  mutable std::mutex mutex_;            ///< held for a pointer copy; of what follows
  std::size_t index_;
  mutable api::SnapshotPtr kept_;  ///< the last one; it always has the robot at the index
};

}  // namespace aprsim::server
