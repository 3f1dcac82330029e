#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "modbus/register_map.hpp"
#include "protocols/modbus/security/client_rights.hpp"
#include "protocols/net/listener_options.hpp"
#include "protocols/record/wire_tap.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/duration_histogram.hpp"
#include "world/base/result.hpp"

/// The conveyor's PLC, and the servers that a scene describes, over Modbus/TCP and Modbus Security.
namespace aprsim::modbus_server {

/// In virtual time each request takes its poll period where "modbus" is declared to pace.
struct ModbusServerOptions {
  std::string map = {};  ///< name of a server of the scene; empty = the conveyor's PLC

  /// With `tls` it is a port of Modbus Security: clients show a certificate, and `roles` hold.
  protocols::ListenerOptions listener{.port = 1502, .limits = {.at_once = 128}};
  /// One more port in front of the same registers, with `tls`; absent = none.
  std::optional<protocols::ListenerOptions> secure = {};
  RoleRules roles = {};
  /// A TLS handshake must be finished this long after the connection.
  std::chrono::milliseconds handshake_timeout{5000};
  std::vector<std::uint8_t> unit_ids;  ///< others get exception 11; none = any unit id is ours
  bool read_only = false;              ///< functions that write get exception 1
  /// Requests a connection may make in a second; further ones get exception 6. 0 = no limit.
  double max_requests_per_s = 0;
  /// The drive trips when the belt runs and no write comes for so long, in simulated time; armed by
  /// the first write. 0 = never.
  std::chrono::milliseconds watchdog{0};
  /// A request must be complete this long after its first byte, however it drips. Below the 5 s
  /// after which a stalled peer has to be gone.
  std::chrono::milliseconds partial_timeout{4000};
  /// Replies must be taken off our hands within this time.
  std::chrono::milliseconds write_timeout{4000};
  /// Closes a connection that has sent no request for so long; 0 = never.
  std::chrono::milliseconds idle_timeout{0};
  /// A write that the simulation has not applied by then is answered with exception 4.
  std::chrono::milliseconds apply_deadline{1000};
  std::chrono::milliseconds stop_deadline{100};  ///< after which an accepted stop is confirmed
  /// Replies kept for one connection before its requests wait [bytes].
  std::size_t max_output_bytes = std::size_t{64} * 1024;
  modbus::ConveyorScaling scaling;
  protocols::WireTap* tap = nullptr;  ///< sees the messages; outlives the server
};

/// Name of the listener in logs, records and the ports file: "modbus" or "modbus.NAME", with TLS
/// "modbus_tls" or "modbus_tls.NAME".
[[nodiscard]] std::string listener_name(const ModbusServerOptions& options);

struct ModbusServerStats {
  std::uint64_t accepted = 0;    ///< connections taken
  std::uint64_t refused = 0;     ///< connections closed at once: over the limit, not allowed
  std::uint64_t dropped = 0;     ///< connections we ended: stalled, idle, unreadable stream
  std::uint64_t open = 0;        ///< connections now
  std::uint64_t requests = 0;    ///< complete requests
  std::uint64_t exceptions = 0;  ///< of these, answered with an exception
  api::DurationHistogram::Counts answer_times;  ///< from request to reply, in this process
};

/// Serves the register map to many clients at once from one thread of its own.
///
/// Reads return the latest snapshot. A write to the drive's registers becomes a command. Its reply
/// is sent once a snapshot contains it, so later reads on any connection see it. Until then only
/// the writing connection waits. A write that stops the belt is always accepted, and confirmed
/// after `stop_deadline` at the latest; this also limits the wait of a write before it. A
/// client that closes has at most one turn of its unread writes executed. Exceptions beyond the
/// protocol's own checks: 3 value outside its register's range; 4 no conveyor, or the write was not
/// confirmed within `apply_deadline` (it may still take effect); 6 the simulation accepts no
/// commands now, or the request rate is exceeded: nothing was changed. A server of the scene has
/// its own addresses, and its exceptions are those of MapBank.
class ModbusServer {
 public:
  /// Keeps references to both; they must outlive the server.
  ModbusServer(ModbusServerOptions options, api::CommandSink& sink,
               const api::SnapshotSource& source);
  ~ModbusServer();
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  /// Listens and starts the thread; returns the port. Fails with the listener's name
  /// (field), address, port and cause. Once only. Thread: the owner's.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Port of `secure` after start().
  [[nodiscard]] std::uint16_t secure_port() const;
  /// Accepts no more connections or requests, sends replies until the drain deadline, closes
  /// everything and joins. A second call has no effect. Thread: the owner's.
  void stop();

  /// Thread: any.
  [[nodiscard]] ModbusServerStats stats() const;
  /// The same for the port `secure`; absent = there is none.
  [[nodiscard]] std::optional<ModbusServerStats> secure_stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::modbus_server
