#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/cell_event.hpp"
#include "world/cell/conveyor_drive.hpp"
#include "world/cell/simulated_robot.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::world {

/// Finds what happens in a cell by comparing it with how it was when it was last looked at. What
/// has not changed costs a comparison of numbers: of the whole cell's ties and contacts, and of
/// each robot's. Thread: sim.
class CellWatch {
 public:
  /// When it is looked at.
  struct Now {
    std::uint64_t step = 0;
    SimTime time{};
  };
  /// What of it is to be kept with a state: contacts that may be over.
  struct Apart {
    physics::ContactPair pair;
    std::uint64_t since = 0;  ///< step

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [pair, since] = self;
      io(pair, since);
    }
  };
  using State = std::vector<Apart>;

  /// Takes the cell as it is; nothing has happened.
  void begin(std::shared_ptr<const api::CellDescription> cell, const physics::PhysicsWorld& physics,
             std::span<const SimulatedRobot> robots, const ConveyorDrive* belt, Now now,
             State apart);
  [[nodiscard]] const State& save() const { return apart_; }

  // ---- after a command
  void look_at_robot(int robot, const SimulatedRobot& now_robot, Now now);
  void look_at_belt(const ConveyorDrive& belt, Now now);
  // ---- after a step
  void look(const physics::PhysicsWorld& physics, std::span<const SimulatedRobot> robots,
            const ConveyorDrive* belt, Now now);

  /// What is not found by looking.
  void add(Now now, api::CellEvent event);

  /// In their order, without sequence and epoch.
  [[nodiscard]] std::vector<api::CellEvent>& found() { return found_; }

 private:
  struct Robot {
    api::Ticket ticket = 0;
    api::ActionState state = api::ActionState::kNone;
    bool protective_stop = false;
    int held = -1;
  };

  void look_at_grips(const physics::PhysicsWorld& physics, std::span<const SimulatedRobot> robots,
                     Now now);
  void look_at_contacts(const physics::PhysicsWorld& physics, Now now);
  void end_contacts(Now now);
  void look_at_ties(const physics::PhysicsWorld& physics, Now now);
  void tell_command(Now now, api::CellEventKind kind, int robot, api::Ticket ticket,
                    std::string text);
  void tell_contact(Now now, api::CellEventKind kind, const physics::ContactPair& pair,
                    std::string text);
  [[nodiscard]] const std::string& name_of(int id) const;
  [[nodiscard]] const std::string& name_of(const api::ContactSide& side) const;

  std::shared_ptr<const api::CellDescription> cell_;
  std::vector<Robot> robots_;
  api::DriveFault belt_fault_ = api::DriveFault::kNone;
  bool contacts_known_ = false;  ///< else they are taken as they are
  std::uint64_t contacts_version_ = 0, ties_version_ = 0;
  std::vector<physics::ContactPair> touching_;  ///< by their keys
  State apart_;                                 ///< by their keys; none of them touches
  std::vector<physics::Ties> ties_;             ///< of bodies and tools
  std::vector<bool> lost_;
  std::vector<api::CellEvent> found_;
};

}  // namespace aprsim::world
