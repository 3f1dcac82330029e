#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "protocols/access/audit_log.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::protocols {

/// One document, request or reply on a wire.
struct WireEvent {
  std::string source;    ///< listener, "crcl.fanuc", or "page"
  std::string peer;      ///< address and port
  std::string identity;  ///< of the client's certificate; empty = no credentials
  bool from_client = false;
  bool poll = false;  ///< requests or reports the state, changes nothing
  std::chrono::system_clock::time_point time;
  std::string type;             ///< "MoveToType"; empty for Modbus
  std::int64_t id = 0;          ///< CommandID or transaction
  std::string state;            ///< of a status; else the error of a document, if any
  double latency_s = 0;         ///< of a reply, since its request
  std::string data;             ///< as on the wire, cut to WireTap::kMaxData
  std::size_t data_bytes = 0;   ///< before it was cut; the tap's
  std::uint64_t number = 0;     ///< in the order of the tap, from 1; the tap's
  double sim_time_s = 0;        ///< since the epoch's start; the tap's
  std::uint64_t sim_epoch = 0;  ///< as in Snapshot; the tap's
};

using WireEventPtr = std::shared_ptr<const WireEvent>;

/// Keeps the messages of listeners for pages, without ever blocking a listener. Commands are kept
/// for kKeep; where they need more memory than allowed, the oldest of the source with most bytes
/// are dropped. Polls are kept only while a page wants them, and displace no commands. Thread: any.
class WireTap {
 public:
  static constexpr std::size_t kMaxData = 4096;   ///< of one event [bytes]
  static constexpr std::size_t kMaxPolls = 1024;  ///< the latest
  static constexpr std::size_t kMaxPollBytes = std::size_t{2} << 20;
  static constexpr std::chrono::minutes kKeep{15};
  static constexpr std::size_t kKeptAnyway =
      500;  ///< commands of a source that are kept regardless of age

  /// `max_bytes`: of all commands. The source outlives the tap.
  explicit WireTap(const api::SnapshotSource& source, std::size_t max_bytes = std::size_t{16} << 20)
      : source_(source), max_bytes_(max_bytes) {}

  /// Also writes commands of the wires to this audit log; those of pages are written elsewhere.
  /// Call it before the listeners start.
  void audit_to(AuditLog* audit) { audit_ = audit; }

  [[nodiscard]] bool wants_polls() const { return wants_polls_.load(std::memory_order_relaxed); }
  /// Turning it off drops all kept polls.
  void want_polls(bool on);

  void record(WireEvent event);

  /// Appends the events from number `from` on in order, about `max_bytes` at most; returns the
  /// number to continue with.
  [[nodiscard]] std::uint64_t read(std::uint64_t from, bool with_polls, std::size_t max_bytes,
                                   std::vector<WireEventPtr>& out) const;
  /// Commands that were dropped.
  [[nodiscard]] std::uint64_t given_up() const;

 private:
  struct Kept {
    std::deque<WireEventPtr> events;
    std::size_t bytes = 0;

    void add(WireEventPtr event);
    void drop_oldest();
  };
  void audit(const WireEvent& event) const;
  void give_up_commands(std::chrono::system_clock::time_point now);

  const api::SnapshotSource& source_;
  const std::size_t max_bytes_;
  AuditLog* audit_ = nullptr;
  std::atomic<bool> wants_polls_{false};
  mutable std::mutex mutex_;              // of all below
  std::map<std::string, Kept> commands_;  // by source
  std::size_t command_bytes_ = 0;
  Kept polls_;
  std::uint64_t last_number_ = 0, given_up_ = 0;
};

}  // namespace aprsim::protocols
