#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/cell/machines/conveyor_drive.hpp"
#include "world/cell/machines/simulated_robot.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::world {

/// Detects events in a cell by comparing its state with the one at the last call. Unchanged parts
/// cost a comparison of version numbers. Thread: sim.
class EventDetector {
 public:
  /// The step whose state is compared.
  struct Now {
    std::uint64_t step = 0;
    SimTime time{};
  };
  /// A contact that may be over: part of a saved state.
  struct SeparatedContact {
    physics::ContactPair pair;
    std::uint64_t since = 0;  ///< step

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [pair, since] = self;
      io(pair, since);
    }
  };
  using State = std::vector<SeparatedContact>;

  /// Begins with the present state, without events. `cell` names the parts in events.
  void begin(std::shared_ptr<const api::CellDescription> cell, const physics::PhysicsWorld& physics,
             std::span<const SimulatedRobot> robots, const ConveyorDrive* belt, Now now,
             State apart);
  [[nodiscard]] const State& save() const { return apart_; }

  // ---- after a command
  void detect_robot_events(int robot, const SimulatedRobot& now_robot, Now now);
  void detect_drive_trip(const ConveyorDrive& belt, Now now);
  // ---- after a step
  void detect(const physics::PhysicsWorld& physics, std::span<const SimulatedRobot> robots,
              const ConveyorDrive* belt, Now now);

  // ---- events that comparison cannot detect
  void add(Now now, api::CellEvent event);
  void report_fault(Now now, api::CellEventKind kind, const api::InjectedFault& fault);

  /// Detected events in their order, without sequence and epoch; the caller removes them.
  [[nodiscard]] std::vector<api::CellEvent>& found() { return found_; }

 private:
  struct Robot {
    api::Ticket ticket = 0;
    api::ActionState state = api::ActionState::kNone;
    bool protective_stop = false;
    int held = -1;
  };

  void detect_grasps(const physics::PhysicsWorld& physics, std::span<const SimulatedRobot> robots,
                     Now now);
  void detect_contacts(const physics::PhysicsWorld& physics, Now now);
  void report_ended_contacts(Now now);
  void detect_simplification(const physics::PhysicsWorld& physics, Now now);
  void report_command(Now now, api::CellEventKind kind, int robot, api::Ticket ticket,
                      std::string text);
  void report_contact(Now now, api::CellEventKind kind, const physics::ContactPair& pair,
                      std::string text);
  [[nodiscard]] const std::string& name_of(int id) const;
  [[nodiscard]] const std::string& name_of(const api::ContactSide& side) const;

  std::shared_ptr<const api::CellDescription> cell_;
  std::vector<Robot> robots_;
  api::DriveFault belt_fault_ = api::DriveFault::kNone;
  bool contacts_known_ = false;  ///< else the present ones become known without events
  std::uint64_t contacts_version_ = 0, grouping_version_ = 0;
  std::vector<physics::ContactPair> touching_;    ///< by their keys
  State apart_;                                   ///< by their keys; none of them touches
  std::vector<physics::BodyGrouping> groupings_;  ///< of bodies and tools
  std::vector<bool> lost_;
  std::vector<api::CellEvent> found_;
};

}  // namespace aprsim::world
