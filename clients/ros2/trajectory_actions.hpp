#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "aprsim/v1/cell.pb.h"
#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/dds/wakeup.hpp"
#include "clients/ros2/trajectory/follow_call.hpp"
#include "clients/wires/endpoints.hpp"

namespace aprsim::ros2 {

/// The action /ROBOT/joint_trajectory_controller/follow_joint_trajectory of each robot, where
/// ros2_controllers' JointTrajectoryController of this name has it. Works in a thread of its own;
/// its functions may be called by any. Errors of DDS end the thread, and come back by check().
class TrajectoryActions {
 public:
  /// `ros_namespace`: before the names of the actions, "/" = none.
  TrajectoryActions(Node& node, std::string ros_namespace);
  ~TrajectoryActions();
  TrajectoryActions(const TrajectoryActions&) = delete;
  TrajectoryActions& operator=(const TrajectoryActions&) = delete;

  /// The cell and its daemon from now on; goals of robots that stay are kept.
  void set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell);
  /// Simulated time of the latest snapshot.
  void set_time(const google::protobuf::Duration& time);
  /// The daemon has gone: goals are refused until set_cell().
  void disconnect();
  /// Throws the error that has ended the thread.
  void check();

 private:
  struct Arm;
  struct CallEvent {
    std::uint64_t arm = 0;  ///< its number
    std::uint64_t call = 0;
    FollowCall::Event event;
  };
  /// Input of the thread.
  struct Inbox {
    std::optional<v1::CellDescription> cell;
    std::vector<CallEvent> events;
  };

  void run();
  void work();
  void apply_cell(const v1::CellDescription& cell);
  std::unique_ptr<Arm> make_arm(const v1::RobotDescription& robot);
  void apply(const CallEvent& event);
  void serve(Arm& arm, const google::protobuf::Duration& now, bool connected);
  [[nodiscard]] client::Endpoints daemon();

  Node& node_;
  std::string namespace_;
  Wakeup wakeup_;
  std::mutex mutex_;  ///< of the five below
  Inbox inbox_;
  client::Endpoints daemon_;
  google::protobuf::Duration now_;
  bool connected_ = false;
  std::exception_ptr error_;
  std::vector<std::unique_ptr<Arm>> arms_;  ///< of the thread
  std::uint64_t arms_made_ = 0;             ///< of the thread
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::ros2
