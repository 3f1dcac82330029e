#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <unordered_set>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::server::journal {

/// The lines that the cameras have sent in a replay. Thread: one at a time.
class VisionLines {
 public:
  void add(const api::Snapshot& snapshot);
  /// Lines before this moment are unknown.
  void begin_late() { whole_ = false; }

  /// Whether the robot's camera has sent this line.
  [[nodiscard]] bool has(const std::string& robot, const std::string& line) const;
  /// Whether all lines of the run so far are known.
  [[nodiscard]] bool whole() const { return whole_; }

 private:
  struct Camera {
    std::shared_ptr<const api::CellDescription> cell;  ///< of the latest line
    std::uint64_t epoch = 0, frame = 0;                ///< of the latest line
    std::unordered_set<std::size_t> lines;             ///< their digests
  };

  std::map<std::string, Camera> cameras_;  ///< by robot
  bool whole_ = true;
};

}  // namespace aprsim::server::journal
