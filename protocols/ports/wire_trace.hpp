#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

/// All that goes over the wires, for whoever keeps it. Beside the tap, which gives events up for
/// those that come, this is the whole of it.
namespace aprsim::protocols {

enum class WireKind { kCrcl, kModbus, kVision, kGrpc, kWeb };
enum class WireContent { kOpened, kReceived, kSent, kClosed };

/// One connection of a client.
struct WireConnection {
  WireKind kind = WireKind::kCrcl;
  std::string listener;      ///< as in the ports file
  std::uint64_t number = 0;  ///< among all of the process, from 1
  std::string peer;          ///< address and port
};

/// One thing that happened on a connection.
struct WireRecord {
  std::shared_ptr<const WireConnection> connection;
  WireContent content = WireContent::kOpened;
  std::chrono::system_clock::time_point wall{};
  std::uint64_t epoch = 0, step = 0;     ///< of the latest snapshot
  std::chrono::nanoseconds sim_time{0};  ///< of that
  std::string data;    ///< a document, unit, line or message, whole; of what is none, its bytes
  std::string method;  ///< of gRPC, "/aprsim.v1.ControlService/Pause"
  std::string text;    ///< why a connection ended, what was wrong with what came
};

class WireTrace {
 public:
  virtual ~WireTrace() = default;
  /// Takes it, or counts it as missing; never waits. Thread: any.
  virtual void note(WireRecord record) = 0;
};

}  // namespace aprsim::protocols
