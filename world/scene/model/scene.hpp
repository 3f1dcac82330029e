#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "world/api/description/cell_description.hpp"
#include "world/api/values/pose.hpp"
#include "world/scene/model/camera.hpp"
#include "world/scene/model/device.hpp"
#include "world/scene/model/modbus_server.hpp"
#include "world/scene/model/ode_settings.hpp"
#include "world/scene/model/parts.hpp"
#include "world/scene/model/robot.hpp"
#include "world/scene/model/tool.hpp"

/// A cell as data. Loaded from YAML by scene_loader.hpp; everything SI, frames as named.
namespace aprsim::scene {

struct StaticBox {
  std::string name;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Pose X_WS;  ///< centre
};

/// A light barrier whose beam runs straight across the belt.
struct PhotoEye {
  std::string name;
  double x_m = 0;       ///< of the beam along the belt
  double height_m = 0;  ///< of the beam above the belt
};

struct Conveyor {
  Pose X_WC;  ///< centre of the belt's top face, +x forward
  double length_m = 0, width_m = 0;
  double max_speed_m_s = 0, max_accel_m_s2 = 0;
  double max_decel_m_s2 = 0.5;        ///< of every ordinary stop and slowing down
  double emergency_decel_m_s2 = 2.0;  ///< of an emergency stop
  std::vector<PhotoEye> photo_eyes;
};

/// A property of contacts by pair of surfaces.
struct SurfacePairs {
  double gear_tray = 0, gear_gear = 0, gear_ground = 0;
  double tray_belt = 0, tray_ground = 0, tray_tray = 0, robot = 0;
};
/// Coulomb's coefficients where a scene gives none.
inline constexpr SurfacePairs kUsualFriction = {.gear_tray = 0.35,
                                                .gear_gear = 0.3,
                                                .gear_ground = 0.4,
                                                .tray_belt = 0.8,
                                                .tray_ground = 0.4,
                                                .tray_tray = 0.3,
                                                .robot = 0.5};

/// How contacts of what rests are simplified; see world/physics/simplification.hpp.
enum class Simplification {
  kOff,
  kVirtualJoints,  ///< IMECE2019-11345, algorithms 1-2
  kMerge,          ///< composite rigid bodies
  kDormant,        ///< merge; what rests on its carrier also leaves the solver
};

/// Engine of joints and contacts; see world/physics/engine.
enum class PhysicsEngine {
  kAprsim,  ///< our contact solver
  kOde,     ///< coarse, for comparison with the paper
};

struct Physics {
  double step_s = 1e-3;
  double gravity_m_s2 = 9.81;
  SurfacePairs friction = kUsualFriction;
  SurfacePairs restitution;            ///< share of the speed of approach that an impact gives back
  SurfacePairs rolling_m, spinning_m;  ///< torque across and about the normal, per normal force
  std::vector<MaterialPair> materials;  ///< pairs that are not listed are as those of gears
  /// Residual of the contacts at the end of a step, in velocity. Those of driven bodies, such as
  /// fingers, are always solved to 1e-8 m/s; a step that converges slowly ends at 3e-5 m/s. A
  /// larger value is faster and coarser.
  double residual_m_s = 1e-8;
  Simplification simplification = Simplification::kDormant;
  double simplify_speed_m_s = 1e-3;  ///< e1 of Algorithm 1
  double simplify_accel_m_s2 = 0.5;  ///< e2 of Algorithm 1
  double simplify_force_n = 0.3;     ///< e of Algorithm 2
  PhysicsEngine engine = PhysicsEngine::kAprsim;
  OdeSettings ode;  ///< of kOde
};

struct Scene {
  std::string name;
  std::string file;
  std::string text;  ///< YAML, with the types of other files; empty = made without a text
  std::vector<std::string> type_files;  ///< absolute paths of the files of types that it names
  std::uint64_t seed = 1;
  Physics physics;
  std::map<std::string, GearType> gear_types;
  std::map<std::string, TrayType> tray_types;
  std::map<std::string, PartType> part_types;
  std::vector<Robot> robots;
  std::vector<Camera> cameras;
  std::vector<Tool> tools;  ///< listed by the scene; tools_of() gives all
  std::optional<Conveyor> conveyor;
  std::optional<api::LightCurtainDescription> light_curtain;
  std::vector<StaticBox> fixed;
  std::vector<Fixture> fixtures;
  bool floor = true;  ///< ground plane z = 0
  std::vector<TrayInstance> trays;
  std::vector<GearInstance> gears;  ///< loose and in slots alike; a slot's gear has its slot's pose
  std::vector<PartInstance> parts;
  std::vector<Device> devices;  ///< of extensions
  std::vector<ModbusServer> modbus_servers;
};

}  // namespace aprsim::scene
