#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <google/protobuf/duration.pb.h>

namespace aprsim::ros2 {

using GoalId = std::array<std::uint8_t, 16>;

/// The result of a goal, in the numbers of its action.
struct ActionResult {
  std::int32_t error_code = 0;
  std::string error_string;
};

/// States of a goal, with the numbers of action_msgs/msg/GoalStatus.
enum class GoalState : std::int8_t {
  kUnknown = 0,
  kAccepted = 1,
  kExecuting = 2,
  kCanceling = 3,
  kSucceeded = 4,
  kCanceled = 5,
  kAborted = 6,
};

/// A goal that was accepted.
struct GoalEntry {
  GoalId id{};
  google::protobuf::Duration stamp;  ///< simulated time of its acceptance
  GoalState state = GoalState::kAccepted;
  ActionResult result;                               ///< once it has ended
  std::chrono::steady_clock::time_point ended_at{};  ///< for expire()
};

/// The goals of an action server, by the rules of ROS's rcl_action. Thread: one.
class GoalTable {
 public:
  /// How long ended goals are kept, and how many. rcl_action keeps them for ten seconds.
  static constexpr std::chrono::seconds kKept{60};
  static constexpr std::size_t kMostEnded = 100;

  /// Return codes of action_msgs/srv/CancelGoal.
  struct CancelAnswer {
    std::int8_t return_code = 0;   ///< 0 none, 2 unknown goal, 3 goal that has ended
    std::vector<GoalEntry> goals;  ///< that are now cancelling
  };

  /// Adds an accepted goal; false = its identifier is in use.
  bool add(const GoalId& id, const google::protobuf::Duration& stamp);
  /// The goal has begun.
  void execute(const GoalId& id);
  /// The goal has ended; does nothing to one that had ended before.
  void end(const GoalId& id, GoalState state, ActionResult result,
           std::chrono::steady_clock::time_point now);
  /// Cancels one goal or several: an identifier of zeros and a time of 0 mean all, a time means
  /// those accepted at or before it, besides the goal of the identifier.
  [[nodiscard]] CancelAnswer cancel(const GoalId& id, const google::protobuf::Duration& stamp);
  /// Drops ended goals that were kept long enough; true = some were dropped.
  bool expire(std::chrono::steady_clock::time_point now);

  [[nodiscard]] const GoalEntry* find(const GoalId& id) const;
  /// In the order of their acceptance.
  [[nodiscard]] const std::vector<GoalEntry>& goals() const { return goals_; }

 private:
  [[nodiscard]] GoalEntry* at(const GoalId& id);
  std::vector<GoalEntry> goals_;
};

/// Whether a goal has ended.
[[nodiscard]] bool has_ended(GoalState state);

}  // namespace aprsim::ros2
