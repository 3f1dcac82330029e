#pragma once

#include <optional>
#include <string>
#include <vector>

/// Values that commands and statuses share, as the document writes them: in whatever units the
/// connection uses (crcl/units.hpp). DataPrimitives.xsd.
namespace aprsim::crcl {

/// PointType (X, Y, Z) and VectorType (I, J, K).
struct Vector {
  double x = 0, y = 0, z = 0;
  bool operator==(const Vector&) const = default;
};

/// PoseType. The Y axis is ZAxis x XAxis.
struct Pose {
  Vector point;
  Vector x_axis{1, 0, 0};
  Vector z_axis{0, 0, 1};
  bool operator==(const Pose&) const = default;
};

/// PoseToleranceType; any of the five may be absent. Length units and angle units.
struct PoseTolerance {
  std::optional<double> x_point, y_point, z_point, x_axis, z_axis;
  bool operator==(const PoseTolerance&) const = default;
};

/// The Trans/Rot Speed/Accel types: absolute in units per second (or per second squared), or
/// relative as a fraction of the robot's maximum.
struct Rate {
  bool relative = false;
  double value = 0;
  bool operator==(const Rate&) const = default;
};

/// Which of the four rates.
enum class RateKind { kTransSpeed, kTransAccel, kRotSpeed, kRotAccel };

/// JointPositionToleranceSettingType.
struct JointTolerance {
  int joint = 0;  ///< 1-based
  double tolerance = 0;
  bool operator==(const JointTolerance&) const = default;
};

/// ParameterSettingType.
struct ParameterSetting {
  std::string name, value;
  bool operator==(const ParameterSetting&) const = default;
};

}  // namespace aprsim::crcl
