#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/api/values/planning_mode.hpp"
#include "world/robot/avoidance/convex_shape.hpp"

namespace aprsim::robot {

/// Something that an arm must not touch, in the arm's base frame B.
struct Obstacle {
  enum class Kind : std::uint8_t {
    kFixed,  ///< tables, belt, floor
    kPart,   ///< gears, trays, tools that no robot has: a gripper may touch them at a move's ends
    kRobot,  ///< another arm and what it carries, where it is or will be
    kPerson,
  };
  friend constexpr Kind last_of(Kind) { return Kind::kPerson; }

  ConvexShape shape;
  Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  Kind kind = Kind::kFixed;
  std::uint32_t name = 0;  ///< index into Surroundings::names

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [shape, X_BS, kind, name] = self;
    io(shape, X_BS, kind, name);
  }
};

/// A shape that moves with the flange F.
struct CarriedShape {
  ConvexShape shape;
  Eigen::Isometry3d X_FS = Eigen::Isometry3d::Identity();
  bool held = false;       ///< by the gripper; else part of it
  std::uint32_t name = 0;  ///< index into Surroundings::names

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [shape, X_FS, held, name] = self;
    io(shape, X_FS, held, name);
  }
};

/// Everything around one arm, and what it carries, at the moment when a move is planned. A plan
/// with surroundings is a function of them, so that a saved state has them while it is made.
struct Surroundings {
  api::PlanningMode mode = api::PlanningMode::kCheck;
  double clearance_m = 0;      ///< to keep
  bool self_collision = true;  ///< links of the arm collide with each other
  std::vector<std::string> names;
  std::vector<Obstacle> obstacles;
  std::vector<CarriedShape> carried;
  std::uint64_t motions_of_others = 0;  ///< that other robots had begun

  /// Allocated memory and the value itself, approximately.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this + obstacles.size() * sizeof(Obstacle) +
           carried.size() * sizeof(CarriedShape) + names.size() * sizeof(std::string);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [mode, clearance_m, self_collision, names, obstacles, carried, motions_of_others] = self;
    io(mode, clearance_m, self_collision, names, obstacles, carried, motions_of_others);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(clearance_m >= 0 && clearance_m <= 1, "a clearance beyond 0 to 1 m");
    for (const Obstacle& each : obstacles) {
      in.require(each.name < names.size(), "an obstacle without a name");
    }
    for (const CarriedShape& each : carried) {
      in.require(each.name < names.size(), "a carried shape without a name");
    }
  }
};

/// Where controllers get the surroundings of their robots from. Thread: sim.
class SurroundingsSource {
 public:
  virtual ~SurroundingsSource() = default;
  /// Those of a robot now. Allocates.
  [[nodiscard]] virtual std::shared_ptr<const Surroundings> gather(
      int robot, api::PlanningMode mode) const = 0;
  /// Motions that the other robots have begun.
  [[nodiscard]] virtual std::uint64_t motions_of_others(int robot) const = 0;
};

}  // namespace aprsim::robot
