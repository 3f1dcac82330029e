#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

/// Values of actions in SI units, and their tolerances.
namespace aprsim::trace {

/// Physical quantity of a number.
enum class Quantity {
  kLength,            ///< [m]
  kAngle,             ///< [rad]
  kSpeed,             ///< [m/s]
  kAcceleration,      ///< [m/s^2]
  kTurnSpeed,         ///< [rad/s]
  kTurnAcceleration,  ///< [rad/s^2]
  kWait,              ///< commanded [s]
  kShare,             ///< 0 to 1
  kTorque,            ///< [Nm]
  kCount,             ///< counts of a register
  kNumber,            ///< anything else
};

struct Number {
  Quantity quantity = Quantity::kNumber;
  double value = 0;
};

using Value = std::variant<std::string, Number, Eigen::Quaterniond>;

struct Field {
  std::string name;
  Value value;
};

/// Tolerances within which two values count as equal.
struct Tolerance {
  double position_mm = 0.5;    ///< commanded positions
  double angle_deg = 0.5;      ///< commanded joints and orientations
  double rate_percent = 1;     ///< speeds, accelerations, torques
  double setting = 0.01;       ///< shares, such as the gripper's
  double wait_s = 0.005;       ///< commanded waits
  double register_counts = 0;  ///< values written to registers
  double time_s = 0.5;         ///< durations and pauses
  double time_percent = 10;    ///< likewise; what is more of both counts
  double end_mm = 1;           ///< reported end positions
  double end_deg = 0.5;        ///< likewise
  double seen_mm = 5;          ///< final positions seen by a camera
  double seen_deg = 5;         ///< likewise, of trays
};

/// One name of a tolerance, with its meaning and its place.
struct ToleranceName {
  const char* name;
  double Tolerance::*place;
  const char* meaning;
};
[[nodiscard]] const std::vector<ToleranceName>& tolerance_names();

/// Difference of two values. `amount` and `limit` are in SI units, or 1 for texts.
struct Difference {
  double amount = 0;
  double limit = 0;
  /// Ratio to the tolerance; a large number for texts and for zero tolerance.
  [[nodiscard]] double weight() const;
};

/// Compares two values; absent if they are equal within the tolerance. Values of different kinds
/// always differ.
[[nodiscard]] std::optional<Difference> difference(const Value& a, const Value& b,
                                                   const Tolerance& tolerance);

/// The value with its display unit: mm, deg, %.
[[nodiscard]] std::string text_of(const Value& value);
/// "x 1.0 mm farther (412.0 mm, was 411.0 mm)".
[[nodiscard]] std::string difference_text(const std::string& name, const Value& a, const Value& b);

}  // namespace aprsim::trace
