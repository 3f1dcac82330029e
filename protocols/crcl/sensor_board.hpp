#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "crcl/documents.hpp"
#include "crcl/sensor_status.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/guard.hpp"
#include "world/base/result.hpp"

namespace aprsim::crcl_server {

/// Quantity of a reading, for its unit.
enum class Quantity { kNone, kLength, kForce, kTorque };

/// The SI value in the connection's unit, as statuses have it, and back.
[[nodiscard]] double in_unit(double si, Quantity quantity, const crcl::Units& units);
[[nodiscard]] double in_si(double value, Quantity quantity, const crcl::Units& units);

struct SensorSignal {
  api::Signal signal;
  Quantity quantity = Quantity::kNone;
};

/// The sensors of one robot: those available, those enabled, and their readings.
///
/// force_torque          contact forces on the tool in the robot's frame, with the weight and
///                       inertia of what it holds; also MotoFit, ForceTorqueSim and
///                       RemoteCrclSensor with whatever follows
/// force_torque_tool     the same along the axes of the tool; also ATINetFT
/// part_present          whether the gripper holds something, a part or a tray
/// separation            of the gripper's pads
/// joint_torque_1 ...    torque of each joint's drive, as CRCL numbers and turns them
/// light_curtain         whether it is broken, in a cell that has one; with it come
/// light_curtain_1,
///                       ..., the distance in each of its beams
class SensorBoard {
 public:
  /// `beams` of the cell's light curtain, 0 = none.
  SensorBoard(JointMap joints, int beams) : joints_(std::move(joints)), beams_(beams) {}

  /// Reports the sensor from now on, under the name by which it was enabled. Error kNotFound lists
  /// the available sensors.
  [[nodiscard]] Result<void> enable(const crcl::EnableSensor& command);
  [[nodiscard]] Result<void> disable(const crcl::DisableSensor& command);

  /// Signal of a guard on that sensor, enabled or not: for a force/torque sensor Fx, Fy, Fz, Tx,
  /// Ty or Tz.
  [[nodiscard]] Result<SensorSignal> find(const std::string& sensor_id,
                                          const std::optional<std::string>& sub_field) const;

  /// The enabled sensors, in the order of their enabling within each kind. `time_ms` since 1970.
  [[nodiscard]] crcl::SensorStatuses statuses(const api::Snapshot& snapshot, std::size_t robot,
                                              std::int32_t read_count, std::int64_t time_ms,
                                              const crcl::Units& units) const;

 private:
  enum class Kind { kForceTorqueR, kForceTorqueT, kOnOff, kScalar };
  struct Sensor {
    Kind kind;
    SensorSignal signal;  // of one that has a single value
  };
  struct Enabled {
    crcl::EnableSensor as;
    Sensor sensor;
  };
  [[nodiscard]] Result<Sensor> sensor(const std::string& id) const;
  void add_beams(crcl::SensorStatuses& out, const crcl::SensorReading& curtain,
                 const api::LightCurtainSnapshot& seen, const crcl::Units& units) const;

  JointMap joints_;
  int beams_;
  std::vector<Enabled> enabled_;
};

}  // namespace aprsim::crcl_server
