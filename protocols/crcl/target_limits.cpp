#include "protocols/crcl/target_limits.hpp"

#include <algorithm>
#include <string_view>

#include <spdlog/fmt/fmt.h>

namespace aprsim::crcl_server {
namespace {

struct Bounds {
  double low, high;
};

std::string describe(std::string_view what, double value, const Bounds& bounds, auto unit,
                     bool clamped) {
  const double limit = value < bounds.low ? bounds.low : bounds.high;
  return fmt::format("{} at {:.3f} {} {} limit {:.3f} {}{}", what, crcl::from_si(value, unit),
                     crcl::name_of(unit), value < bounds.low ? "less than" : "greater than",
                     crcl::from_si(limit, unit), crcl::name_of(unit),
                     clamped ? ", moved onto it" : "");
}

void add(std::optional<std::string>& note, const std::string& sentence) {
  note = note ? *note + "; " + sentence : sentence;
}

}  // namespace

CartesianLimits cartesian_limits(const api::RobotDescription& robot,
                                 const std::optional<Eigen::Vector3d>& min_R,
                                 const std::optional<Eigen::Vector3d>& max_R) {
  CartesianLimits limits{robot.reach_min_R, robot.reach_max_R};
  if (min_R) limits.min_R = limits.min_R.cwiseMax(*min_R);
  if (max_R) limits.max_R = limits.max_R.cwiseMin(*max_R);
  return limits;
}

Result<std::optional<std::string>> fit(Pose& X_RT, const CartesianLimits& limits, bool clamp,
                                       crcl::LengthUnit unit) {
  constexpr const char* kAxes[] = {"X", "Y", "Z"};
  std::optional<std::string> note;
  for (int i = 0; i < 3; ++i) {
    const Bounds bounds{limits.min_R[i], limits.max_R[i]};
    double& value = X_RT.p[i];
    if (value >= bounds.low && value <= bounds.high) continue;
    const std::string sentence = describe(kAxes[i], value, bounds, unit, clamp);
    if (!clamp) return fail(ErrorCode::kUnreachable, kAxes[i], sentence + ": out of reach");
    add(note, sentence);
    value = std::clamp(value, bounds.low, bounds.high);
  }
  return note;
}

Result<std::optional<std::string>> fit(api::MoveJoints& move, const api::RobotDescription& robot,
                                       bool clamp, crcl::AngleUnit unit) {
  std::optional<std::string> note;
  if (!clamp) return note;
  for (api::JointTarget& target : move.targets) {
    const api::JointDescription& joint = robot.joints[static_cast<std::size_t>(target.joint)];
    const Bounds bounds{joint.lower_rad, joint.upper_rad};
    if (target.position_rad >= bounds.low && target.position_rad <= bounds.high) continue;
    add(note, describe(fmt::format("Joint {}", target.joint + 1), target.position_rad, bounds, unit,
                       true));
    target.position_rad = std::clamp(target.position_rad, bounds.low, bounds.high);
  }
  return note;
}

}  // namespace aprsim::crcl_server
