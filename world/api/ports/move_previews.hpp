#pragma once

#include <functional>
#include <optional>

#include "world/api/commands/robot_command.hpp"
#include "world/api/values/move_preview.hpp"
#include "world/base/result.hpp"

/// Moves that are planned without being made. They change nothing.
namespace aprsim::api {

struct PreviewRequest {
  RobotCommand command;              ///< a move; guards have no effect
  std::optional<PlanningMode> mode;  ///< how it regards what stands around; absent = as is set
};

class MovePreviews {
 public:
  virtual ~MovePreviews() = default;

  using Answer = std::function<void(Result<MovePreview>)>;
  /// Plans the move from the cell's present state, also of a paused cell, and calls `answer`, once:
  /// from a thread of its own, for which the answer must not wait; or at once, here, with an error.
  /// A move that would be refused is no error. Errors: field and value of a wrong request;
  /// kFailedPrecondition for a move that takes too long; kUnavailable when too many wait or the
  /// simulation ends. Thread: any.
  virtual void ask(PreviewRequest request, Answer answer) = 0;
};

}  // namespace aprsim::api
