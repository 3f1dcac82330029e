#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "protocols/net/listener_options.hpp"
#include "protocols/record/wire_tap.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/result.hpp"

/// ROS-Industrial's Simple Message as the controllers of the robots serve it.
namespace aprsim::simple_message {

enum class ControllerKind : std::uint8_t {
  kFanucKarel,    ///< ROS-Industrial's Karel programs and a gripper server
  kMotomanFs100,  ///< MotoROS 1.9 on an FS100
};

/// The ports of one robot. Both controllers use big-endian numbers.
struct SimpleMessageOptions {
  /// Common to the three ports, but for the port numbers.
  protocols::ListenerOptions listener{.limits = {.at_once = 8, .per_address = 8}};
  std::uint16_t motion_port = 0, state_port = 0;
  std::uint16_t gripper_port = 0;  ///< the Fanuc's gripper server; the Motoman's I/O server
  int robot = 0;                   ///< index into CellDescription::robots
  ControllerKind controller = ControllerKind::kFanucKarel;
  double joint_speed = 0.2;  ///< of the Fanuc's moves: share of the joints' speeds
  double rounding = 0.5;     ///< of the Fanuc's moves: CNT / 100
  /// Period of the Motoman's increments.
  std::chrono::milliseconds interpolation_clock{4};
  /// A connection that has not taken a message after this time is closed.
  std::chrono::milliseconds write_timeout{4000};
  /// A claim of the robot is given up after this time, as MotoROS does.
  std::chrono::milliseconds claim_timeout{5000};
  protocols::WireTap* tap = nullptr;  ///< sees the messages; outlives the server
};

struct SimpleMessagePorts {
  std::uint16_t motion = 0, state = 0, gripper = 0;
};

struct SimpleMessageStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit, not allowed
  std::uint64_t dropped = 0;   ///< connections we ended because of the peer
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t requests = 0;  ///< complete requests
  std::uint64_t rejected = 0;  ///< of these, answered with another result than success
  std::uint64_t skipped = 0;   ///< states not sent to slow readers
  api::DurationHistogram::Counts answer_times;  ///< from request to reply, in this process
};

/// Serves motion, state and gripper of one robot from one thread of its own.
///
/// States are sent at the controller's period of wall time, also while the cell is paused.
/// A request never waits for physics, except where the controller makes its client wait: the
/// Fanuc's third point for the end of the first, and START_TRAJ_MODE and the servos' power for the
/// robot. Motions are streams of the cell (world/api/commands/trajectory_command.hpp), so that the
/// robot has one commander.
class SimpleMessageServer {
 public:
  /// Keeps references to both; they must outlive the server.
  SimpleMessageServer(SimpleMessageOptions options, api::CommandSink& sink,
                      const api::SnapshotSource& source);
  ~SimpleMessageServer();
  SimpleMessageServer(const SimpleMessageServer&) = delete;
  SimpleMessageServer& operator=(const SimpleMessageServer&) = delete;

  /// Listens on the three ports and starts the thread. Fails with listener, address, port and
  /// cause; the error's field is motion, state or gripper. Once only. Thread: the owner's.
  [[nodiscard]] Result<SimpleMessagePorts> start();
  /// Accepts no more connections or requests, sends what is queued until the drain deadline, closes
  /// everything and joins. A second call has no effect. Thread: the owner's.
  void stop();

  /// The robot has this index in another scene. `change` lets the snapshots have it, on the
  /// server's thread. Thread: the owner's, between start and stop.
  void set_robot(int robot, std::function<void()> change);

  /// Thread: any.
  [[nodiscard]] SimpleMessageStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::simple_message
