#pragma once

#include <memory>
#include <optional>

#include "protocols/simple_message/controller.hpp"
#include "protocols/simple_message/gripper_valves.hpp"
#include "protocols/simple_message/robot_link.hpp"
#include "protocols/simple_message/stream_ends.hpp"

namespace aprsim::simple_message {

/// ROS-Industrial's Karel programs on the Fanuc: each point is acknowledged when it is read, and
/// then handed to a motion program that moves to one point and knows one more. Thread: the
/// listener's.
class FanucController final : public Controller {
 public:
  explicit FanucController(ListenerContext& context, RobotLink& link);

  [[nodiscard]] bool take_motion(Connection& connection, std::span<const std::uint8_t> request,
                                 bool known_length) override;
  [[nodiscard]] bool take_gripper(Connection& connection, std::span<const std::uint8_t> request,
                                  bool known_length) override;
  [[nodiscard]] bool owes(const Connection&) const override { return false; }
  void motion_connected(Connection& connection) override;
  void motion_gone(Connection& connection) override;
  [[nodiscard]] bool yields_motion() override { return false; }
  void advance() override;
  [[nodiscard]] bool waits() const override { return point_.has_value(); }
  void report_ends() override {
    const api::SnapshotPtr now = link_.latest();
    ends_.report(*now, link_.robot(*now));
  }
  [[nodiscard]] std::chrono::milliseconds state_period() const override;
  [[nodiscard]] std::vector<std::string> states() override;

 private:
  void take_special(Connection& connection, std::int32_t sequence);
  void acknowledge(Connection& connection, std::int32_t sequence, ReplyCode code);
  [[nodiscard]] bool in_range(const JointVector& joints, const api::Snapshot& now) const;
  void follow_stream(const api::Snapshot& now);
  [[nodiscard]] bool program_is_free(const api::Snapshot& now) const;
  /// Hands the waiting point to the motion program, if that takes it.
  void hand_over(const api::Snapshot& now);
  void release();

  ListenerContext& context_;
  RobotLink& link_;
  GripperValves gripper_;
  StreamEnds ends_;
  Connection* client_ = nullptr;         // of the motion port
  std::optional<JointVector> point_;     // acknowledged, not handed over yet
  api::Ticket stream_ = 0, latest_ = 0;  // our stream; our latest command
  std::uint64_t epoch_ = 0;
  int positions_ = 0;  // sent since the last status
};

}  // namespace aprsim::simple_message
