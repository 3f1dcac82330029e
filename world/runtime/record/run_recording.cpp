#include "world/runtime/record/run_recording.hpp"

#include <new>

#include "world/cell/world.hpp"

namespace aprsim::world {

void RunRecording::begin_epoch(RunTime time, std::uint64_t seed, const std::string* loaded,
                               const std::shared_ptr<const scene::Scene>& scene,
                               const World& world) {
  if (recorder_ == nullptr) return;
  recorder_->began(time, seed, loaded, scene);
  record_checkpoint(time, world);
}

void RunRecording::record_command(RunTime time, const QueuedCommand& command,
                                  const Error* failure) {
  if (recorder_ != nullptr) recorder_->applied(time, command, failure);
}

void RunRecording::record_event(const api::CellEventPtr& event) {
  if (recorder_ != nullptr) recorder_->happened(event);
}

void RunRecording::record_stop(RunTime time, const std::string& why) {
  if (recorder_ != nullptr) recorder_->stopped(time, why);
}

void RunRecording::record_step(RunTime time, const World& world) {
  if (recorder_ == nullptr) return;
  if (time.step % kSampleSteps == 0) record_sample(time, world);
  if (time.step % kCheckpointSteps == 0 || recorder_->wants_checkpoint()) {
    record_checkpoint(time, world);
  }
}

void RunRecording::record_wanted_checkpoint(RunTime time, const World& world) {
  if (recorder_ != nullptr && recorder_->wants_checkpoint()) record_checkpoint(time, world);
}

void RunRecording::record_sample(RunTime time, const World& world) {
  try {
    recorder_->sampled(time, sample_of(world));
  } catch (const std::bad_alloc&) {
    // Runs can be compared without this sample.
  }
}

void RunRecording::record_checkpoint(RunTime time, const World& world) {
  try {
    recorder_->saved(time, world.state_hash(), std::make_shared<const WorldState>(world.save()));
  } catch (const std::bad_alloc&) {
    // The next checkpoint may find memory again.
  }
}

}  // namespace aprsim::world
