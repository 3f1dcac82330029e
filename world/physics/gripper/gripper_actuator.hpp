#pragma once

#include <array>

#include "world/physics/gripper/finger_drive.hpp"
#include "world/physics/gripper/gripper_wear.hpp"
#include "world/scene/model/robot.hpp"

namespace aprsim::physics {

/// Command, force, air and wear of a gripper: drives the fingers, or switches the ejector of a cup.
class GripperActuator {
 public:
  explicit GripperActuator(const scene::Gripper& gripper);

  /// 0 closed .. 1 open; a piston has only these two. False if nothing changes.
  bool command(double setting);
  /// Force of each finger, from now on [N]. False if nothing changes.
  bool set_force(double force_n);
  /// False if nothing changes.
  bool set_wear(const GripperWear& wear);
  /// Empties both chambers.
  void vent();

  [[nodiscard]] bool is_closing() const { return setting_ <= 0.5; }  ///< of pistons
  /// Travel at which the fingers stop with nothing between them; `closed_m`: of the closed stop.
  [[nodiscard]] double stop_travel_m(double closed_m) const { return (1 - setting_) * closed_m; }
  [[nodiscard]] double force_n() const { return settings_.force_n; }
  [[nodiscard]] double pad_friction() const { return wear_.pad_friction * settings_.pad_friction; }
  /// Whether the fingers push with their full force.
  [[nodiscard]] bool is_at_full_force() const;

  /// Once a step: advances the air and returns the fingers' drives.
  [[nodiscard]] std::array<FingerDrive, 2> advance(const std::array<FingerMotion, 2>& motion,
                                                   double closed_m, double step_s);

  struct State {
    double setting = 1, force_n = 0;
    LawState law;
    GripperWear wear;

    /// See world/archive/archive.hpp.
    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [setting, force_n, law, wear] = self;
      io(setting, force_n, law, wear);
    }
  };
  [[nodiscard]] State save() const { return {setting_, settings_.force_n, law_, wear_}; }
  void restore(const State& state);

 private:
  [[nodiscard]] bool is_servo() const { return settings_.drive == scene::GripperDrive::kServo; }

  scene::Gripper settings_;  // with the force set last
  double setting_ = 1;
  LawState law_;
  GripperWear wear_;
};

}  // namespace aprsim::physics
