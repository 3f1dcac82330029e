#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "world/robot/trajectory/joint_motion.hpp"
#include "world/robot/trajectory/path_motion.hpp"

namespace aprsim::robot {

/// One motion of a robot of either kind. A copyable value; copies share what was planned. Thread:
/// any, one at a time.
class Motion {
 public:
  Motion() = default;
  explicit Motion(const JointMotion& motion) : motion_(motion) {}

  /// The motion to plan, of the kind that it then is.
  JointMotion& as_joint() { return motion_.emplace<JointMotion>(); }
  PathMotion& as_path() { return motion_.emplace<PathMotion>(); }
  /// The joint motion, if it is one.
  [[nodiscard]] const JointMotion* joint() const { return std::get_if<JointMotion>(&motion_); }

  /// Adds what copies share.
  void list(SharedParts& parts) const {
    if (const auto* path = std::get_if<PathMotion>(&motion_)) path->list(parts);
  }

  /// Advances by `dt` and writes the position. True once at rest at end(), then exactly.
  bool advance(const ArmGeometry& arm, double dt, JointVector& q) {
    auto* joint = std::get_if<JointMotion>(&motion_);
    return joint ? joint->advance(dt, q) : std::get<PathMotion>(motion_).advance(arm, dt, q);
  }
  void brake(const ArmGeometry& arm, Brake how) {
    auto* joint = std::get_if<JointMotion>(&motion_);
    joint ? joint->brake(how) : std::get<PathMotion>(motion_).brake(arm, how);
  }
  /// Speed override 0..1 from now on.
  void set_speed(double fraction) {
    std::visit([fraction](auto& motion) { motion.set_speed(fraction); }, motion_);
  }
  [[nodiscard]] const JointVector& end() const {
    return std::visit([](const auto& motion) -> const JointVector& { return motion.end(); },
                      motion_);
  }

  [[nodiscard]] double duration() const {
    const auto* joint = std::get_if<JointMotion>(&motion_);
    return joint ? joint->duration() : std::get<PathMotion>(motion_).whole_duration();
  }
  /// Adds the positions from the start to the end at intervals of `interval_s`, both ends included;
  /// only before it starts.
  void sample(double interval_s, std::vector<JointVector>& out) const {
    std::visit([&](const auto& motion) { motion.sample(interval_s, out); }, motion_);
  }
  /// Adds `count` positions on the way that is left.
  void remaining(std::size_t count, std::vector<JointVector>& out) const {
    std::visit([&](const auto& motion) { motion.remaining(count, out); }, motion_);
  }

  [[nodiscard]] bool is_planned() const {
    return std::visit([](const auto& motion) { return motion.is_planned(); }, motion_);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [all] = self;
    io(all);
  }

 private:
  std::variant<JointMotion, PathMotion> motion_;
};

}  // namespace aprsim::robot
