#pragma once

#include <cstdint>
#include <span>

#include "world/api/snapshot/snapshot.hpp"
#include "world/physics/contacts/arm_force.hpp"

namespace aprsim::world {

/// What robots touch that is no work, kept for those who look now and then: anything but gears at
/// a gripper, and what it holds. Contacts of one pair within kSameTouch are one touch. Values.
/// Thread: one at a time.
class RobotTouches {
 public:
  static constexpr std::uint64_t kSameTouch = 250;  ///< steps

  /// After a step: the forces on a robot's arm. `has_tool`: its gripper's are its own.
  void add(std::uint64_t step, int robot, std::span<const physics::ArmForce> forces, bool has_tool,
           const api::CellDescription& cell);
  [[nodiscard]] const api::RobotTouchesPtr& list() const { return list_; }
  /// Bodies have other numbers now; each old one's new one.
  void renumber(std::span<const int> new_of);

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [list] = self;
    io(list);
  }

 private:
  api::RobotTouchesPtr list_;
};

}  // namespace aprsim::world
