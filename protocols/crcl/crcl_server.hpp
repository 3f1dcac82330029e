#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "crcl/units.hpp"
#include "protocols/net/listener_options.hpp"
#include "protocols/ports/robot_port.hpp"
#include "protocols/record/wire_tap.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/result.hpp"

/// One robot's CRCL port.
namespace aprsim::crcl_server {

/// In virtual time each GetStatus of a client takes its poll period.
struct CrclServerOptions {
  protocols::ListenerOptions listener{.port = 64444};
  int robot = 0;      ///< index into CellDescription::robots
  crcl::Units units;  ///< of a new connection
  /// Joint positions, speeds and accelerations are in degrees whatever SetAngleUnits says, as in
  /// the reference servers, whose clients count on it; false: they follow the connection's unit.
  bool joints_in_degrees = true;
  /// Documents that violate the schema are treated like broken ones; else they are accepted as far
  /// as they can be decoded.
  bool strict = false;
  /// Targets beyond joint or Cartesian limits are moved onto them, with a note in the
  /// StateDescription; else they are refused. Absent = as the scene's robot does.
  std::optional<bool> clamp_targets;
  /// Box of allowed tool points in the robot's reference frame [m]; absent = the robot's reach.
  std::optional<Eigen::Vector3d> cartesian_min_R, cartesian_max_R;
  /// SetEndEffector is done once the gripper has settled. By default it is done as soon as the
  /// robot has it, as on NIST's servers.
  bool wait_for_end_effector = false;
  std::size_t max_message_bytes = 65'536;
  std::size_t max_program_bytes = 1'048'576;  ///< of a whole CRCLProgram
  /// A program ends when its client disconnects, after the present command; else it continues to
  /// its end.
  bool end_program_with_client = false;
  /// Limit of what unfinished documents of all connections take together [bytes]. Beyond it the
  /// connection with the largest is closed.
  std::size_t max_unfinished_bytes = std::size_t{8} << 20;
  /// Statuses kept for one connection before its next commands wait [bytes].
  std::size_t max_output_bytes = 65'536;
  /// A connection whose peer takes no pending status for this time is closed.
  std::chrono::milliseconds write_timeout{5000};
  /// A document must be complete this long after its first byte.
  std::chrono::milliseconds document_timeout{10'000};
  /// Closes a connection without input for this time; 0 = never.
  std::chrono::milliseconds idle_timeout{0};
  protocols::WireTap* tap = nullptr;  ///< sees the documents; outlives the server
};

struct CommandExecutorOptions;
/// Those of the executor behind a port.
[[nodiscard]] CommandExecutorOptions executor_options(const CrclServerOptions& options);

struct CrclServerStats {
  std::uint64_t accepted = 0;  ///< accepted connections
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit
  std::uint64_t dropped = 0;   ///< connections closed by us: bad XML, too large, stalled, idle
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t commands = 0;  ///< documents and messages received, GetStatus included
  std::uint64_t statuses = 0;  ///< statuses answered
  api::DurationHistogram::Counts answer_times;  ///< from GetStatus to its status, in this process
};

/// Serves CRCL to any number of clients of one robot from one thread of its own.
///
/// Per connection: units and report filters. Per robot, shared by its connections: the latest
/// CommandID, its state and description, StatusID, initialisation, pose overrides. Exactly one
/// status answers each GetStatus, in order, and nothing else is ever sent. All connections may
/// command; the latest command wins.
///
/// Choices where existing servers differ (protocols/CONTROLLERS.md gives the reasons):
/// - CommandID -1 and CRCL_Ready before the first command.
/// - An error is held until InitCanon. Commands in between get that error under their own id.
/// - Ids that repeat or go down are executed.
/// - Before InitCanon only InitCanon, EndCanon, StopMotion and GetStatus are accepted. EndCanon
/// ends
///   motion and leaves the robot initialised. Units stay over InitCanon.
/// - SetEndEffector and relative rates are clamped to 0..1.
/// - A CRCLProgram document is executed, also in the text of a RunProgram command.
/// - GripperStatus is off by default. Its separation is in the connection's length unit.
/// - A broken document stops the robot and closes its connection; the other connections see the
///   error. So does a connection that has commanded and is reset or times out.
/// - A connection that its client closes leaves the motion running. At most one turn of its unread
///   commands is executed.
class CrclServer final : public protocols::RobotPort {
 public:
  /// Keeps references to both; they must outlive the server.
  CrclServer(CrclServerOptions options, api::CommandSink& sink, const api::SnapshotSource& source);
  ~CrclServer() override;
  CrclServer(const CrclServer&) = delete;
  CrclServer& operator=(const CrclServer&) = delete;

  /// Listens and starts the thread; returns the port. Fails with the address, port and cause.
  /// Once only. Thread: the owner's.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Takes no more connections or commands, lets statuses go out until the drain deadline, closes
  /// everything and joins. Motion goes on. Again: nothing. Thread: the owner's.
  void stop();

  /// The robot has this index in another scene. `change` lets the snapshots have it, on the
  /// server's thread. Thread: the owner's, between start and stop.
  void set_robot(int robot, std::function<void()> change);
  /// Sets CrclServerOptions::max_unfinished_bytes. Thread: any.
  void limit_unfinished(std::size_t bytes);

  /// Thread: any.
  [[nodiscard]] CrclServerStats stats() const;

  // Sessions of other listeners, as many as connections; they do not pace virtual time.
  [[nodiscard]] const std::string& robot() const override;
  [[nodiscard]] Result<std::shared_ptr<protocols::RobotSession>> open(
      protocols::RobotSessionOptions options,
      std::shared_ptr<protocols::RobotClient> client) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::crcl_server
