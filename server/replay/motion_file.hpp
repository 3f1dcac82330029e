#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "server/replay/motion_options.hpp"
#include "server/replay/sample_times.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server {

/// Writes the motion of all bodies during a replay (aprsim/v1/motion.proto). Thread: the replay's.
class MotionFile {
 public:
  MotionFile(const MotionOptions& options, const v1::JournalHeader& header);

  /// Samples the world at the requested rate; call it after every step.
  void sample(const world::World& world, world::RunTime time);
  /// Writes the rest and moves the file into its place. Errors: kUnavailable with the file.
  [[nodiscard]] Result<void> finish();

 private:
  void describe(const world::World& world);
  void flush(std::size_t from_bytes);

  SampleTimes times_;
  files::DraftFile file_;
  aprsim::journal::FrameEncoder encoder_;
  v1::JournalHeader header_;
  std::shared_ptr<const api::CellDescription> described_;  ///< in the last header
};

}  // namespace aprsim::server
