#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocols/ports/wire_trace.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::protocols {

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
