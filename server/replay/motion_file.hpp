#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "server/replay/motion_options.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Writes the motion of all bodies during a replay (aprsim/v1/motion.proto). Thread: the replay's.
class MotionFile {
 public:
  MotionFile(MotionOptions options, const v1::JournalHeader& header, const scene::Scene& scene);

  /// Samples the world at the requested rate; call it after every step.
  void sample(const world::World& world, world::RunTime time);
  /// Writes the rest and moves the file into its place. Errors: kUnavailable with the file.
  [[nodiscard]] Result<void> finish();

 private:
  void describe(const world::World& world);
  void flush(std::size_t from_bytes);

  const MotionOptions options_;
  files::DraftFile file_;
  aprsim::journal::FrameEncoder encoder_;
  v1::JournalHeader header_;
  const scene::Scene scene_;
  std::shared_ptr<const api::CellDescription> described_;  ///< in the last header
  std::uint64_t epoch_ = 0;
  double base_s_ = 0, latest_s_ = 0;  ///< simulated time over all epochs
  std::uint64_t next_step_ = 0;       ///< of that time, for the next sample
};

}  // namespace aprsim::server
