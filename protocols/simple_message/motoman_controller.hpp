#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include <boost/asio/steady_timer.hpp>

#include "protocols/simple_message/controller.hpp"
#include "protocols/simple_message/motoman_io.hpp"
#include "protocols/simple_message/motoman_queue.hpp"
#include "protocols/simple_message/stream_ends.hpp"

namespace aprsim::simple_message {

/// MotoROS 1.9 on the Motoman's FS100: trajectories of points, cut into increments, after
/// START_TRAJ_MODE. Thread: the listener's.
class MotomanController final : public Controller {
 public:
  MotomanController(ListenerContext& context, RobotLink& link);

  [[nodiscard]] bool take_motion(Connection& connection, std::span<const std::uint8_t> request,
                                 bool known_length) override;
  [[nodiscard]] bool take_gripper(Connection& connection, std::span<const std::uint8_t> request,
                                  bool known_length) override;
  [[nodiscard]] bool owes(const Connection& connection) const override {
    return pending_ && pending_->connection == &connection;
  }
  void motion_connected(Connection& connection) override;
  void motion_gone(Connection& connection) override;
  [[nodiscard]] bool yields_motion() override;
  void advance() override;
  [[nodiscard]] bool waits() const override { return pending_ || queue_.waits(); }
  void report_ends() override {
    const api::SnapshotPtr now = link_.latest();
    ends_.report(*now, link_.robot(*now));
  }
  [[nodiscard]] std::chrono::milliseconds state_period() const override;
  [[nodiscard]] std::vector<std::string> states() override;

 private:
  /// A request whose reply waits for the cell.
  struct Pending {
    Connection* connection;
    MotionReply reply;  ///< without its result
    Communication communication;
    std::chrono::nanoseconds deadline;  ///< of clock()
    /// Its result once the cell shows it.
    std::function<std::optional<MotionResult>(const api::Snapshot&)> result;
  };

  /// A point for the robot's only group, from either message.
  struct Point {
    std::int32_t group, sequence, valid;
    float time;
    Joints position, velocity;
  };

  [[nodiscard]] std::optional<Message> answer(Connection& connection, const Message& request);
  [[nodiscard]] std::optional<MotionReply> control(Connection& connection, const Message& request);
  [[nodiscard]] MotionReply take_point(const Point& point, MessageType type);
  [[nodiscard]] MotionReply take_points(const TrajectoryPointsExtended& points);
  [[nodiscard]] std::pair<MotionResult, Subcode> judge(const Point& point);
  [[nodiscard]] std::pair<MotionResult, Subcode> add(const Point& point, const api::Snapshot& now);
  [[nodiscard]] MotionReply select_tool(const SelectTool& request) const;

  void start_trajectory_mode(Connection& connection, const Message& request, MotionReply reply);
  [[nodiscard]] std::optional<MotionReply> stop_trajectory_mode(Connection& connection,
                                                                MotionReply reply, bool disconnect);
  void set_servos(Connection& connection, const Message& request, MotionReply reply, bool on);
  void reset_alarm(Connection& connection, const Message& request, MotionReply reply);
  void await(Connection& connection, const Message& request, MotionReply reply,
             std::function<std::optional<MotionResult>(const api::Snapshot&)> result);
  [[nodiscard]] std::optional<api::Ticket> claim(const std::string& who, bool reset);
  void send(Connection& connection, Communication asked, MotionReply reply);

  [[nodiscard]] bool is_ready(const api::Snapshot& now);
  [[nodiscard]] Subcode not_ready_reason(const api::Snapshot& now);
  void follow_stream(const api::Snapshot& now);
  void pause();
  /// The clock of deadlines: in virtual time the cell's, else the wall's.
  [[nodiscard]] std::chrono::nanoseconds clock(const api::Snapshot& now) const;

  ListenerContext& context_;
  RobotLink& link_;
  MotomanIo io_;
  MotomanQueue queue_;
  StreamEnds ends_;
  boost::asio::steady_timer pause_timer_;
  api::Ticket stream_ = 0;  // of INIT_ROS, the job that takes trajectories
  std::uint64_t epoch_ = 0;
  bool connected_ = false, paused_ = false;
  std::optional<Pending> pending_;
};

}  // namespace aprsim::simple_message
