#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "world/runtime/record/recorder.hpp"

namespace aprsim::world {

/// Reports the course of a run to a Recorder, if there is one: epochs, commands, events, and the
/// samples and checkpoints that are due. Thread: sim.
class RunRecording {
 public:
  /// `recorder` outlives the recording; null = nothing is recorded.
  explicit RunRecording(Recorder* recorder) : recorder_(recorder) {}

  [[nodiscard]] bool is_active() const { return recorder_ != nullptr; }

  /// `loaded`: name of the saved state that the epoch begins with; null = none.
  void begin_epoch(RunTime time, std::uint64_t seed, const std::string* loaded,
                   const std::shared_ptr<const scene::Scene>& scene, const World& world);
  /// `failure`: null = the command succeeded.
  void record_command(RunTime time, const QueuedCommand& command, const Error* failure);
  void record_event(const api::CellEventPtr& event);
  void record_stop(RunTime time, const std::string& why);
  /// After a step: the sample and the checkpoint that are due.
  void record_step(RunTime time, const World& world);
  /// Between two steps: a checkpoint, if the recorder wants one.
  void record_wanted_checkpoint(RunTime time, const World& world);

 private:
  void record_sample(RunTime time, const World& world);
  void record_checkpoint(RunTime time, const World& world);

  Recorder* recorder_;
};

}  // namespace aprsim::world
