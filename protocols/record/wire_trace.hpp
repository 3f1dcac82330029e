#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "world/api/ports/ports.hpp"

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

/// A connection's part of the trace, from its opening to its end. Where nobody traces, every call
/// is next to nothing. Thread: the connection's.
class ConnectionTrace {
 public:
  /// Traces nothing.
  ConnectionTrace() = default;
  /// `trace` may be null; it and the source outlive the connection.
  ConnectionTrace(WireTrace* trace, const api::SnapshotSource& source, WireKind kind,
                  std::string listener, std::string peer);
  ~ConnectionTrace() { closed({}); }
  ConnectionTrace(ConnectionTrace&& other) noexcept;
  ConnectionTrace& operator=(ConnectionTrace&& other) noexcept;

  /// Whole, as on the wire; `text`: what was wrong with it.
  void received(std::string_view data, std::string_view text = {}) {
    if (trace_ != nullptr) note(WireContent::kReceived, data, text);
  }
  /// The same for what is answered at once: it is made a record now, and handed over with the next
  /// one or with catch_up(), when the answer is on its way.
  void received_first(std::string_view data);
  void catch_up();
  void sent(std::string_view data) {
    if (trace_ != nullptr) note(WireContent::kSent, data, {});
  }
  /// Counts once.
  void closed(std::string_view why);
  /// 0 = nothing is traced.
  [[nodiscard]] std::uint64_t number() const { return connection_ ? connection_->number : 0; }

 private:
  void note(WireContent content, std::string_view data, std::string_view text);
  [[nodiscard]] WireRecord record_of(WireContent content, std::string_view data,
                                     std::string_view text) const;

  WireTrace* trace_ = nullptr;
  const api::SnapshotSource* source_ = nullptr;
  std::shared_ptr<const WireConnection> connection_;
  std::optional<WireRecord> first_;  ///< made, and not handed over yet
};

/// Notes one thing with the time of now and of the latest snapshot.
void note(WireTrace& trace, const api::SnapshotSource& source, WireRecord record);

}  // namespace aprsim::protocols
