#include "server/listeners/robot_view.hpp"

#include <utility>
#include <variant>

#include "world/api/description/robot_identity.hpp"

namespace aprsim::server {

RobotView::RobotView(api::CommandSink& sink, const api::SnapshotSource& source,
                     api::SnapshotPtr now, int index)
    : sink_(sink),
      source_(source),
      first_(now->cell),
      robot_(first_->robots.at(static_cast<std::size_t>(index))),
      index_(static_cast<std::size_t>(index)),
      kept_(std::move(now)) {}

void RobotView::move_to(int index, api::SnapshotPtr now) {
  const std::lock_guard lock(mutex_);
  index_ = static_cast<std::size_t>(index);
  kept_.swap(now);
}

Result<api::Ticket> RobotView::submit(api::Command command) {
  command.cell = source_.latest()->cell;
  const auto index = api::robot_named(*command.cell, robot_.name);
  if (!index || !api::same_robot(command.cell->robots[*index], robot_)) {
    return fail(ErrorCode::kUnavailable, "robot",
                "the robot " + robot_.name + " has left the cell");
  }
  if (auto* robot = std::get_if<api::RobotCommand>(&command.body)) {
    robot->robot = static_cast<int>(*index);
  } else if (auto* motion = std::get_if<api::TrajectoryCommand>(&command.body)) {
    motion->robot = static_cast<int>(*index);
  }
  return sink_.submit(std::move(command));
}

api::SnapshotPtr RobotView::latest() const {
  api::SnapshotPtr now = source_.latest();
  const std::lock_guard lock(mutex_);
  const auto& robots = now->cell->robots;
  if (now->cell == kept_->cell ||
      (index_ < robots.size() && api::same_robot(robots[index_], robot_))) {
    kept_ = std::move(now);
  }
  return kept_;
}

api::SnapshotPtr RobotView::wait_newer(const api::SnapshotPtr& seen,
                                       std::chrono::steady_clock::time_point deadline) const {
  static_cast<void>(source_.wait_newer(seen, deadline));
  return latest();
}

}  // namespace aprsim::server
