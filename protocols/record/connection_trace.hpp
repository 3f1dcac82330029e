#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocols/ports/wire_trace.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::protocols {

/// Records one connection from its opening to its end. Without a trace, calls cost almost nothing.
/// Thread: the connection's.
class ConnectionTrace {
 public:
  /// Records nothing.
  ConnectionTrace() = default;
  /// `trace` may be null; it and the source outlive the connection.
  ConnectionTrace(WireTrace* trace, const api::SnapshotSource& source, WireKind kind,
                  std::string listener, std::string peer);
  ~ConnectionTrace() { closed({}); }
  ConnectionTrace(ConnectionTrace&& other) noexcept;
  ConnectionTrace& operator=(ConnectionTrace&& other) noexcept;

  /// Records a message as it was on the wire; `text`: its error.
  void received(std::string_view data, std::string_view text = {}) {
    if (trace_ != nullptr) record(WireContent::kReceived, data, text);
  }
  /// The same for a message that is answered at once: the record is created now, and passed on with
  /// the next one or by catch_up(), after the answer was sent.
  void received_first(std::string_view data);
  void catch_up();
  void sent(std::string_view data) {
    if (trace_ != nullptr) record(WireContent::kSent, data, {});
  }
  /// A second call does nothing.
  void closed(std::string_view why);
  /// 0 = no trace.
  [[nodiscard]] std::uint64_t number() const { return connection_ ? connection_->number : 0; }

 private:
  void record(WireContent content, std::string_view data, std::string_view text);
  [[nodiscard]] WireRecord record_of(WireContent content, std::string_view data,
                                     std::string_view text) const;

  WireTrace* trace_ = nullptr;
  const api::SnapshotSource* source_ = nullptr;
  std::shared_ptr<const WireConnection> connection_;
  std::optional<WireRecord> first_;  ///< created and not passed on yet
};

/// Passes on a record with the present time and that of the latest snapshot.
void record(WireTrace& trace, const api::SnapshotSource& source, WireRecord record);

}  // namespace aprsim::protocols
