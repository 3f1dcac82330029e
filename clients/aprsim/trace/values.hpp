#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

/// Values of actions, in SI, and how far two of them may be apart.
namespace aprsim::trace {

/// What a number measures.
enum class Quantity {
  kLength,            ///< [m]
  kAngle,             ///< [rad]
  kSpeed,             ///< [m/s]
  kAcceleration,      ///< [m/s^2]
  kTurnSpeed,         ///< [rad/s]
  kTurnAcceleration,  ///< [rad/s^2]
  kWait,              ///< that was asked for [s]
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

/// What counts as the same.
struct Tolerance {
  double position_mm = 0.5;    ///< of positions that are commanded
  double angle_deg = 0.5;      ///< of joints and orientations that are commanded
  double rate_percent = 1;     ///< of speeds, accelerations, torques
  double setting = 0.01;       ///< of shares, as the gripper's
  double wait_s = 0.005;       ///< of waits that are commanded
  double register_counts = 0;  ///< of what is written to registers
  double time_s = 0.5;         ///< of how long something took, and of pauses
  double time_percent = 10;    ///< likewise; what is more of both counts
  double end_mm = 1;           ///< of where a robot says that it has come to
  double end_deg = 0.5;        ///< likewise
  double seen_mm = 5;          ///< of where the camera sees things in the end
  double seen_deg = 5;         ///< likewise, of trays
};

/// One name of a tolerance, with its meaning and its place.
struct ToleranceName {
  const char* name;
  double Tolerance::*place;
  const char* meaning;
};
[[nodiscard]] const std::vector<ToleranceName>& tolerance_names();

/// How much two values differ. `amount` and `limit` are in SI, or in 1 for texts.
struct Difference {
  double amount = 0;
  double limit = 0;
  /// How many times more than may be; of texts and of what may not differ at all, many.
  [[nodiscard]] double weight() const;
};

/// Nothing where they count as the same. Values of different kinds always differ.
[[nodiscard]] std::optional<Difference> difference(const Value& a, const Value& b,
                                                   const Tolerance& tolerance);

/// The value with its unit, as people want to read it: mm, deg, %.
[[nodiscard]] std::string text_of(const Value& value);
/// "x 1.0 mm farther (412.0 mm, was 411.0 mm)".
[[nodiscard]] std::string difference_text(const std::string& name, const Value& a, const Value& b);

}  // namespace aprsim::trace
