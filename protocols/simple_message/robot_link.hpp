#pragma once

#include <optional>
#include <string>
#include <utility>

#include "protocols/simple_message/controller_state.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::simple_message {

/// The cell's side of one robot. Thread: the listener's.
class RobotLink {
 public:
  RobotLink(const SimpleMessageOptions& options, api::CommandSink& sink,
            const api::SnapshotSource& source)
      : options_(options), sink_(sink), source_(source) {}

  [[nodiscard]] Result<api::Ticket> submit(api::TrajectoryAction action) {
    return sink_.submit(
        {options_.listener.endpoint, api::TrajectoryCommand{options_.robot, std::move(action)}});
  }
  [[nodiscard]] Result<api::Ticket> submit(api::RobotAction action) {
    return sink_.submit(
        {options_.listener.endpoint, api::RobotCommand{options_.robot, std::move(action)}});
  }

  [[nodiscard]] api::SnapshotPtr latest() const { return source_.latest(); }
  [[nodiscard]] const api::RobotSnapshot& robot(const api::Snapshot& snapshot) const {
    return snapshot.robots.at(static_cast<std::size_t>(options_.robot));
  }
  [[nodiscard]] const api::RobotDescription& description(const api::Snapshot& snapshot) const {
    return snapshot.cell->robots.at(static_cast<std::size_t>(options_.robot));
  }
  [[nodiscard]] ControllerState state(const api::Snapshot& snapshot, api::Ticket stream) const {
    return state_of(snapshot, options_.robot, options_.controller, stream);
  }

 private:
  const SimpleMessageOptions& options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
};

}  // namespace aprsim::simple_message
