#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::web {

/// In rising order; web.proto describes each.
enum class FaultSeverity : std::uint8_t { kNote, kWarning, kError, kStop };

struct FaultTime {
  std::uint64_t epoch = 0;
  double sim_time_s = 0;  ///< since the epoch's start
  std::chrono::system_clock::time_point wall;
};

/// All occurrences of one cause at one source.
struct Fault {
  std::uint64_t id = 0;
  FaultSeverity severity = FaultSeverity::kNote;
  std::string source;   ///< a robot's name, "belt", "physics", "simulation" or "cell"
  std::string message;  ///< of the last occurrence
  std::uint64_t count = 0;
  FaultTime first, last;
  bool active = false;  ///< not cleared
};

/// Faults of the cell, one entry a cause, found by comparing successive snapshots. Texts that
/// differ in numbers only have the same cause. Bounded: among inactive entries, the least
/// severe and oldest are dropped first. Thread: one at a time.
class FaultLog {
 public:
  static constexpr std::size_t kMaxFaults = 200;
  static constexpr std::uint64_t kFewMissedSteps = 50;  ///< between two snapshots, without a fault
  /// Whether an error of this robot at this command is not a fault of the cell.
  using Expected = std::function<bool(int robot, api::Ticket ticket)>;

  explicit FaultLog(api::SnapshotPtr first) : before_(std::move(first)) {}

  /// Compares with the previous snapshot; call it for as many as possible. `problem`:
  /// SnapshotSource::problem().
  void update(const api::SnapshotPtr& now, const std::string& problem,
              std::chrono::system_clock::time_point wall, const Expected& expected = {});

  [[nodiscard]] const std::vector<Fault>& faults() const { return faults_; }
  [[nodiscard]] std::uint64_t discarded() const { return discarded_; }
  [[nodiscard]] std::uint64_t revision() const { return revision_; }  ///< counts changes

 private:
  struct Seen {
    FaultSeverity severity;
    std::string source, message;
    std::string cause = {};  ///< empty: the message without its numbers
    std::uint64_t count = 1;
    bool active = false;
  };
  void add(Seen seen);
  void clear(const std::string& source, FaultSeverity severity);
  void detect_epoch(const api::Snapshot& before, const api::Snapshot& now);
  void clear_gone(const api::Snapshot& before, const api::Snapshot& now);
  void detect_robot(int index, const api::Snapshot& before, const api::Snapshot& now,
                    const Expected& expected);
  void detect_belt(const api::Snapshot& before, const api::Snapshot& now);
  void detect_physics(const api::Snapshot& before, const api::Snapshot& now);
  void detect_pace(const api::Snapshot& before, const api::Snapshot& now,
                   const std::string& problem);
  void make_room();

  api::SnapshotPtr before_;
  std::string problem_;
  FaultTime now_;
  std::vector<Fault> faults_;
  std::vector<std::string> causes_;  // of each entry
  std::uint64_t missed_steps_ = 0;   // total
  std::uint64_t last_id_ = 0, discarded_ = 0, revision_ = 0;
};

}  // namespace aprsim::web
