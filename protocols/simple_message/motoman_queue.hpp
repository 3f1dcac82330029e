#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "protocols/simple_message/codec/message.hpp"
#include "protocols/simple_message/robot_link.hpp"

namespace aprsim::simple_message {

/// The points of the Motoman's present trajectory, and how many increments of them wait in the
/// controller's queue. The cell interpolates the points itself; the queue follows from the times.
/// Thread: the listener's.
class MotomanQueue {
 public:
  static constexpr std::int64_t kIncrements = 200;  ///< that the queue holds

  MotomanQueue(RobotLink& link, std::chrono::milliseconds clock) : link_(link), clock_(clock) {}

  /// A new stream of the cell, without points.
  void begin_stream(api::Ticket stream);
  /// The first point of a trajectory: its time is the origin of those of the others.
  void begin(std::int64_t time_ms);
  /// The points are gone, as after a stop of the motion.
  void clear();
  /// Drops what is not cut into increments: points that wait for the robot to stand, and the end of
  /// the latest one. The trajectory's new end; nullopt = all of it is in the queue.
  [[nodiscard]] std::optional<SimTime> drop_uncut(const api::Snapshot& now);

  /// Whether the latest point is still being cut into increments.
  [[nodiscard]] bool is_cutting(const api::Snapshot& now) const;
  /// Increments in the queue.
  [[nodiscard]] std::int64_t count(const api::Snapshot& now) const;
  /// Whether a trajectory is under way.
  [[nodiscard]] bool empty(const api::Snapshot& now) const { return count(now) == 0; }

  /// Adds a point in the model's joints. A time that is not after the latest one's is accepted and
  /// ignored. Error: the cell takes no commands now.
  [[nodiscard]] Result<void> add(std::int64_t time_ms, JointVector position_rad,
                                 JointVector velocity_rad_s);
  /// Whether points wait for the robot to stand, or may come to wait for that.
  [[nodiscard]] bool waits() const { return !waiting_.empty() || !handed_.empty(); }
  /// Hands over points that have waited for the robot to stand.
  void advance(const api::Snapshot& now);

 private:
  struct Point {
    std::int64_t time_ms;
    JointVector position_rad, velocity_rad_s;
  };

  [[nodiscard]] Result<void> append(bool begins, Point point);
  [[nodiscard]] std::int64_t whole_ms() const { return end_ms_ - origin_ms_; }
  [[nodiscard]] std::int64_t passed_ms(const api::Snapshot& now) const;
  [[nodiscard]] std::int64_t increments(std::int64_t from_ms, std::int64_t to_ms) const;
  [[nodiscard]] std::int64_t full_at_ms(std::int64_t from_ms) const;
  [[nodiscard]] bool stands(const api::Snapshot& now) const;
  [[nodiscard]] bool takes_points(const api::Snapshot& now) const;
  void check_handed(const api::Snapshot& now);

  RobotLink& link_;
  const std::chrono::milliseconds clock_;
  api::Ticket stream_ = 0;
  api::Ticket begun_ = 0, latest_ = 0;  // the command that began the trajectory; the latest one
  std::int64_t origin_ms_ = 0, end_ms_ = 0;
  std::vector<std::int64_t> off_clock_ms_;  // points between two ticks, from the origin, ascending
  bool begins_ = true;                      // the next point begins a trajectory
  /// Handed over, and not yet known to be accepted.
  std::deque<std::pair<api::Ticket, Point>> handed_;
  std::vector<Point> waiting_;  // for the robot to stand
};

}  // namespace aprsim::simple_message
