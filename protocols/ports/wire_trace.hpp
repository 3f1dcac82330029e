#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

/// Complete traffic of the wires, for the journal. (The tap keeps only the latest part.)
namespace aprsim::protocols {

enum class WireKind { kCrcl, kModbus, kVision, kGrpc, kWeb, kSimpleMessage };
enum class WireContent { kOpened, kReceived, kSent, kClosed };

/// One connection of a client.
struct WireConnection {
  WireKind kind = WireKind::kCrcl;
  std::string listener;      ///< as in the ports file
  std::uint64_t number = 0;  ///< in this process, from 1
  std::string peer;          ///< address and port
};

/// An event of a connection.
struct WireRecord {
  std::shared_ptr<const WireConnection> connection;
  WireContent content = WireContent::kOpened;
  std::chrono::system_clock::time_point wall{};
  std::uint64_t epoch = 0, step = 0;     ///< of the latest snapshot
  std::chrono::nanoseconds sim_time{0};  ///< of that
  std::string data;    ///< a whole document, unit, line or message; else the bytes
  std::string method;  ///< of gRPC, "/aprsim.v1.ControlService/Pause"
  std::string text;    ///< why a connection ended, or the error of a message
};

class WireTrace {
 public:
  virtual ~WireTrace() = default;
  /// Accepts the record or counts it as missing; never blocks. Thread: any.
  virtual void record(WireRecord record) = 0;
};

}  // namespace aprsim::protocols
