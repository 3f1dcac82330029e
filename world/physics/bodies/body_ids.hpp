#pragma once

namespace aprsim::physics {

/// Ids of all bodies that can be in contact: free bodies as in the scene (trays, then gears, then
/// parts, then tools), then each robot's palm, two fingers and links. kGround is the id of
/// everything fixed.
class BodyIds {
 public:
  /// `parts`: trays, gears and parts.
  BodyIds(int parts, int tools) : parts_(parts), free_(parts + tools) {}

  [[nodiscard]] int free_count() const { return free_; }
  [[nodiscard]] int palm(int robot) const { return free_ + robot * kPerRobot; }
  [[nodiscard]] int link(int robot, int link) const { return palm(robot) + kGripperParts + link; }

  [[nodiscard]] int part_count() const { return parts_; }
  [[nodiscard]] int tool(int index) const { return parts_ + index; }
  [[nodiscard]] bool is_part(int id) const { return id >= 0 && id < parts_; }
  [[nodiscard]] int tool_of(int id) const { return id - parts_; }
  [[nodiscard]] bool is_free(int id) const { return id >= 0 && id < free_; }
  [[nodiscard]] bool is_robot(int id) const { return id >= free_; }
  [[nodiscard]] bool is_gripper(int id) const {
    return is_robot(id) && in_robot(id) < kGripperParts;
  }
  [[nodiscard]] bool is_link(int id) const { return is_robot(id) && in_robot(id) >= kGripperParts; }
  [[nodiscard]] int robot_of(int id) const { return (id - free_) / kPerRobot; }
  /// Number of a gripper's part: 0 palm, 1-2 fingers.
  [[nodiscard]] int part_of(int id) const { return in_robot(id); }
  [[nodiscard]] int link_of(int id) const { return in_robot(id) - kGripperParts; }

 private:
  static constexpr int kGripperParts = 3, kPerRobot = 16;
  [[nodiscard]] int in_robot(int id) const { return (id - free_) % kPerRobot; }

  int parts_ = 0, free_ = 0;
};

}  // namespace aprsim::physics
